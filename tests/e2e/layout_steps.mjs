// Cards of the page at several widths: none hides another.
import { check, post } from './harness.mjs';
import { ViewerPage } from './viewer_page.mjs';

const kSheet = 'layout';
const kScene = { grid: { columns: 11, rows: 11, widthM: 1, heightM: 1 }, gravityMps2: {} };
const kViewports = [
  ['wide', { viewport: { width: 1440, height: 900 } }],
  ['narrow', { viewport: { width: 1024, height: 768 } }],
  ['phone', { viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true }],
  ['phone across', { viewport: { width: 844, height: 390 }, hasTouch: true, isMobile: true }],
];

/** Pairs of cards that are seen of which one covers a part of the other. */
function overlaps({ page }) {
  return page.evaluate(() => {
    const cards = [...document.querySelectorAll('.card')].filter((card) => card.checkVisibility());
    const name = (card) => card.id || card.className;
    const found = [];
    cards.forEach((card, i) => {
      const a = card.getBoundingClientRect();
      for (const other of cards.slice(i + 1)) {
        const b = other.getBoundingClientRect();
        const isOver = a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom;
        if (isOver) found.push([name(card), name(other)]);
      }
    });
    return found;
  });
}

/** Buttons and lists that are seen and too small for a finger. */
function small({ page }) {
  return page.evaluate(() => {
    const targets = [...document.querySelectorAll('button, select, summary')].filter((each) => each.checkVisibility());
    const isSmall = (each) => each.getBoundingClientRect().width < 44 || each.getBoundingClientRect().height < 44;
    return targets.filter(isSmall).map((each) => each.id || each.textContent.trim() || each.outerHTML.slice(0, 80));
  });
}

/** Two notices: there is no cut to undo, and none to make again. */
async function notify({ page }) {
  await page.focus('#canvas');
  for (const [keys, what] of [['Control+z', 'to undo'], ['Control+y', 'to redo']]) {
    await page.keyboard.press(keys);
    await page.locator('.notice', { hasText: what }).waitFor();
  }
}

export function layoutSteps(steps, browser, { url }) {
  for (const [name, options] of kViewports) {
    steps.step(`hint, notices, statistics and panels leave one another room: ${name}`, async () => {
      if (name === kViewports[0][0]) {
        await post(url, 'SheetService/CreateSheet', { sheetId: kSheet, scene: kScene, paused: true });
      }
      const visit = { ...options, colorScheme: 'light', reducedMotion: 'reduce', isFirstVisit: true };
      const viewer = await ViewerPage.open(browser, `${url}/?sheet=${kSheet}`, visit);
      const { page } = viewer;
      await viewer.untilDrawn('k.connection === "live" && k.isPaused && k.framesDrawn > 0');
      const haveRoom = async (state, isMeant = () => false) => {
        const hidden = (await overlaps(viewer)).filter((pair) => !isMeant(pair));
        if (hidden.length > 0) await viewer.screenshot(`layout-${name}-${state}`);
        check(hidden.length === 0, `${name}, ${state}: ${hidden.map((pair) => pair.join(' and ')).join('; ')}`);
      };
      await page.waitForSelector('#first-hint', { state: 'visible' });
      await notify(viewer);
      await haveRoom('first visit');
      await page.click('#statistics-toggle');
      await viewer.choose('cut');
      await notify(viewer);
      await haveRoom('statistics and cut panel');
      if (name.startsWith('phone')) {
        await page.click('#controls-more');
        check((await small(viewer)).length === 0, `too small for a finger: ${await small(viewer)}`);
        await page.click('#controls-more');
      }
      await page.click('[data-panel=physics]');
      await notify(viewer);
      // An open panel lies over what stands at the bottom of a phone.
      const isBottom = (id) => ['cut-panel', 'controls', 'tools'].includes(id);
      await haveRoom('physics', (pair) => name.startsWith('phone') && pair.includes('panel-physics') && pair.some(isBottom));
      if (name.startsWith('phone')) check((await small(viewer)).length === 0, `too small for a finger: ${await small(viewer)}`);
      const { height } = await page.locator('#statistics').boundingBox();
      check(height > 50, `${name}: the statistics have ${height} px`);
      await page.close();
    });
  }
}
