// The viewer without a mouse, in both themes, for those who hear it, and on a phone.
import { readFile } from 'node:fs/promises';
import { audit } from './axe.mjs';
import { check, kPatienceMs, post, root } from './harness.mjs';
import { ViewerPage } from './viewer_page.mjs';

const kScene = {
  grid: { columns: 31, rows: 31, widthM: 1, heightM: 1 },
  placement: { origin: { x: -0.5, z: 0.2 }, xAxis: { x: 1 }, yAxis: { y: Math.cos(0.7), z: Math.sin(0.7) } },
  gravityMps2: {},
};
// Pictures are of panels that have come, not of panels that are coming.
const kDesktop = { viewport: { width: 1280, height: 720 }, reducedMotion: 'reduce' };
const kPhone = { viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true, reducedMotion: 'reduce' };

/** A recording of the sheet that is watched, as a file for an input. */
async function recorded({ page }) {
  await page.keyboard.press('Control+s');
  await page.click('#save-recording');
  await page.waitForFunction(() => !/, 0 B$/.test(document.getElementById('recording-text').textContent));
  const downloading = page.waitForEvent('download');
  await page.click('#recording');
  const buffer = await readFile(await (await downloading).path());
  return { name: 'access.kerfstream', mimeType: '', buffer };
}

export function accessSteps(steps, browser, { url }) {
  let viewer;
  let recording;
  const open = async (options) => {
    const opened = await ViewerPage.open(browser, `${url}/?sheet=access`, options);
    await opened.untilDrawn('k.connection === "live" && k.isPaused && k.framesDrawn > 0');
    return opened;
  };

  steps.step('a sheet is cut by keys alone', async () => {
    await post(url, 'SheetService/CreateSheet', { sheetId: 'access', scene: kScene, paused: true });
    viewer = await open({ ...kDesktop, colorScheme: 'light' });
    const { keyboard } = viewer.page;
    await keyboard.press('c');
    await keyboard.press('i');
    // From beside the sheet to beside it, through its middle.
    const reach = Math.ceil(((await viewer.at(1, 0.5)).x - (await viewer.at(0, 0.5)).x) / 2 / 16) + 4;
    for (let i = 0; i < reach; ++i) await keyboard.press('ArrowLeft');
    await viewer.shows('.cross output', 'beside the sheet');
    await keyboard.press('Enter');
    for (let i = 0; i < reach; ++i) await keyboard.press('ArrowRight');
    const place = await viewer.page.textContent('.cross output');
    check(/^[\d.-]+, [\d.-]+ m$/.test(place), `in the middle of the sheet the cross says ${place}`);
    await keyboard.press('Shift+ArrowUp');
    await keyboard.press('Enter');
    for (let i = 0; i < reach; ++i) await keyboard.press('ArrowRight');
    await viewer.screenshot('keys-cut');
    await keyboard.press('Enter');
    check((await viewer.read('k.pieces')) === 1, 'the first Enter at a new place cuts already');
    await keyboard.press('Enter');
    await viewer.until('k.pieces === 2');
    await viewer.notice(/^Cut: 2 pieces/);
    await keyboard.press('Escape');
    check(await viewer.page.isHidden('.cross'), 'the cross stays after Escape');
  });

  steps.step('a cut is undone and made again, by buttons and by keys', async () => {
    const { keyboard } = viewer.page;
    for (const [act, pieces] of [
      [() => viewer.page.click('#undo'), 1],
      [() => viewer.page.click('#redo'), 2],
      [() => keyboard.press('Control+z'), 1],
      [() => keyboard.press('Control+Shift+z'), 2],
      [() => keyboard.press('Control+z'), 1],
      [() => keyboard.press('Control+y'), 2],
    ]) {
      await act();
      await viewer.until('k.pieces === given.pieces', { pieces });
    }
  });

  steps.step('Escape lets go of what is held by keys', async () => {
    const { keyboard } = viewer.page;
    // A static analysis says what it leaves out.
    const request = { name: 'sheets/access', analysis: { static: { maxIterations: 1 } } };
    const becomesHeld = async (isHeld) => {
      const deadline = Date.now() + kPatienceMs;
      for (;;) {
        const { left_out: leftOut = [] } = (await post(url, 'SheetService/AnalyzeSheet', request)).static;
        if (leftOut.includes('grabs') === isHeld) return;
        check(Date.now() < deadline, isHeld ? 'the server knows of no grab' : 'the server holds the vertex still');
      }
    };
    await keyboard.press('g');
    await keyboard.press('ArrowDown');
    await keyboard.press('Enter');
    await keyboard.press('ArrowRight');
    await becomesHeld(true);
    await keyboard.press('Escape');
    await becomesHeld(false);
    check(await viewer.page.isHidden('.cross'), 'the cross stays after Escape');
    await keyboard.press('c');
  });

  steps.step('a circle is dragged, a vertex pinned and the view turned by keys', async () => {
    const { keyboard } = viewer.page;
    await keyboard.press('o');
    await keyboard.press('Shift+ArrowUp');
    await keyboard.press('Enter');
    for (let i = 0; i < 3; ++i) await keyboard.press('ArrowRight');
    await keyboard.press('Enter');
    await keyboard.press('Enter');
    await viewer.until('k.pieces > 2');
    await keyboard.press('p');
    await keyboard.press('ArrowDown');
    await keyboard.press('Enter');
    await viewer.until('k.pinnedVertices.length === 1');
    await keyboard.press('v');
    const before = await viewer.at(0, 0);
    await keyboard.press('ArrowLeft');
    await keyboard.press('+');
    await viewer.allDrawn();
    const after = await viewer.at(0, 0);
    check(Math.hypot(after.x - before.x, after.y - before.y) > 5, 'the view did not turn');
  });

  steps.step('the theme is the system’s, or chosen and kept, and the scene follows', async () => {
    const shade = async (name) => (await viewer.colours([{ x: 1100, y: 200 }], name))[0].reduce((sum, c) => sum + c, 0);
    const light = await shade('theme-light');
    await viewer.page.emulateMedia({ colorScheme: 'dark' });
    await viewer.until('k.framesDrawn > 0');
    const dark = await shade('theme-dark');
    check(light > 600 && dark < 250, `the page is ${light} in the light and ${dark} in the dark`);
    await viewer.page.keyboard.press('h');
    check((await shade('theme-chosen')) > 600, 'light was chosen, and it is dark');
    await viewer.page.reload();
    await viewer.untilDrawn('k.connection === "live" && k.framesDrawn > 0');
    check((await shade('theme-kept')) > 600, 'the choice is not kept');
    await viewer.page.keyboard.press('h');
    await viewer.page.keyboard.press('h');
    check((await viewer.page.getAttribute('html', 'data-theme')) === 'system', 'the third press is not the system again');
  });

  steps.step('the help lists the keys that are bound', async () => {
    await viewer.page.keyboard.press('?');
    await viewer.page.locator('#help[open]').waitFor();
    const caps = await viewer.page.locator('#help dt').allTextContents();
    for (const key of ['V', 'C', 'Space', 'Ctrl+Z', 'Ctrl+Shift+Z or Ctrl+Y', 'Enter', '← → ↑ ↓', 'A', 'M', 'J', 'H', 'Q']) {
      check(caps.includes(key), `the help does not list ${key}`);
    }
    await viewer.screenshot('help-keys');
    await viewer.page.keyboard.type('undo');
    const found = viewer.page.locator('#help dd:visible');
    await viewer.page.waitForFunction(() => document.querySelectorAll('#help dd:not([hidden])').length < 9);
    check((await found.allTextContents()).some((text) => text.startsWith('Undo')), 'the help does not find undo');
    // Escape would only empty the field.
    await viewer.page.fill('#help input', '');
    await viewer.page.keyboard.press('Escape');
    await viewer.page.locator('#help').waitFor({ state: 'hidden' });
  });

  steps.step('the Tab key goes through everything, and everything has a name', async () => {
    await viewer.page.keyboard.press('c');
    await viewer.page.focus('#canvas');
    const ring = () => viewer.page.evaluate(() => getComputedStyle(document.getElementById('canvas')).outlineStyle);
    check((await ring()) === 'none', 'there is a ring around the window though Tab was not pressed');
    const seen = [];
    for (;;) {
      await viewer.page.keyboard.press('Tab');
      const at = await viewer.page.evaluate(() => {
        const element = document.activeElement;
        if (element === document.body) return undefined;
        const text = (node) => node?.textContent.trim() ?? '';
        const label = element.labels?.length ? text(element.labels[0]) : '';
        const name = element.getAttribute('aria-label') || label || text(element) || element.title;
        const { outlineStyle } = getComputedStyle(element);
        return { id: element.id || element.dataset.tool || element.dataset.panel || element.dataset.mode, name, outlineStyle };
      });
      if (!at || at.id === 'canvas') break;
      check(at.name, `a control without a name: ${JSON.stringify(at)}`);
      check(at.outlineStyle !== 'none', `the focus on ${at.name} cannot be seen`);
      seen.push(at.id);
      check(seen.length < 100, `Tab goes in circles: ${seen}`);
    }
    await viewer.page.focus('#sheet-picker');
    await viewer.page.keyboard.press('Shift+Tab');
    check((await ring()) !== 'none', 'the focus on the sheet by Tab cannot be seen');
    const order = ['sheet-picker', 'cut', 'curve', 'pause', 'undo', 'wireframe', 'theme', 'help-open', 'sheets', 'physics'];
    const places = order.map((id) => seen.indexOf(id));
    check(!places.includes(-1) && places.every((place, i) => i === 0 || place > places[i - 1]), `the order is ${seen}`);
    await viewer.page.keyboard.press('Escape');
    await viewer.page.focus('[data-panel=sheets]');
    await viewer.page.keyboard.press('Enter');
    check(await viewer.page.evaluate(() => document.activeElement.id === 'panel-sheets'), 'the focus is not in the panel');
    await viewer.page.keyboard.press('Escape');
    const back = await viewer.page.evaluate(() => document.activeElement.dataset.panel);
    check(back === 'sheets', `closing the panel leaves the focus at ${back}`);
  });

  steps.step('a menu that the mouse opens has the keyboard', async () => {
    const { page } = viewer;
    const focused = () => page.evaluate(() => document.activeElement.id);
    await page.keyboard.press('v');
    const before = await viewer.at(0, 0);
    await page.click('#save-open');
    check((await focused()) === 'save-png', `the focus is at ${await focused()}`);
    await page.keyboard.press('ArrowDown');
    check((await focused()) === 'save-png-2', `an arrow key moves the focus to ${await focused()}`);
    await page.keyboard.press('Escape');
    check((await page.isHidden('#save-menu')) && (await focused()) === 'save-open', 'Escape does not close it');
    await viewer.allDrawn();
    const after = await viewer.at(0, 0);
    check(Math.hypot(after.x - before.x, after.y - before.y) < 0.5, 'an arrow key in the menu turns the view');
  });

  steps.step('Escape in a panel closes the panel, and leaves a cross and a recording as they are', async () => {
    const { page } = viewer;
    const panelCloses = async () => {
      await page.focus('[data-panel=sheets]');
      await page.keyboard.press('Enter');
      await page.keyboard.press('Escape');
      check(await page.isHidden('#panel-sheets'), 'the panel stays');
    };
    await page.focus('#canvas');
    await page.keyboard.press('c');
    await page.keyboard.press('ArrowLeft');
    await panelCloses();
    check(await page.isVisible('.cross'), 'the cross is gone as well');
    await page.keyboard.press('Escape');
    check(await page.isHidden('.cross'), 'the cross stays after Escape');
    await page.keyboard.press('v');
    recording = await recorded(viewer);
    await page.setInputFiles('#replay-file', recording);
    await viewer.until('k.connection === "replay"');
    await panelCloses();
    check((await viewer.read('k.connection')) === 'replay', 'the recording is closed as well');
    await page.keyboard.press('Escape');
    await viewer.until('k.connection === "live"');
  });

  const auditDialogs = async (viewer) => {
    const { page } = viewer;
    await page.keyboard.press('?');
    await audit(page, 'help');
    await page.keyboard.press('Escape');
    await page.click('[data-panel=sheets]');
    await page.click('#sheet-list .icon');
    await audit(page, 'confirmation');
    await page.keyboard.press('Escape');
    await page.click('#panel-sheets [data-close]');
  };

  const auditStreams = async (viewer, name) => {
    const { page } = viewer;
    await page.keyboard.press('Control+s');
    await audit(page, 'save menu');
    await page.keyboard.press('Escape');
    await page.keyboard.press('u');
    await audit(page, 'statistics');
    await page.keyboard.press('u');
    await page.keyboard.press('q');
    await viewer.until('k.picture?.connection === "live"');
    await audit(page, 'pictures of the server');
    await page.keyboard.press('q');
    await page.setInputFiles('#replay-file', recording);
    await viewer.until('k.connection === "replay" && k.replay.index >= 0');
    await audit(page, 'recording');
    await page.screenshot({ path: `${root}/build/e2e/${name}-recording.png` });
    await page.click('#replay-close');
    await viewer.untilDrawn('k.connection === "live" && k.framesDrawn > 0');
  };

  // Both widths have the same colours, and both themes the same parts.
  for (const [name, colorScheme, options] of [
    ['desktop', 'light', kDesktop],
    ['phone', 'dark', kPhone],
  ]) {
    steps.step(`axe finds nothing at ${name} width, ${colorScheme}, with every panel`, async () => {
      const page = await open({ ...options, colorScheme });
      await audit(page.page, 'nothing open');
      for (const panel of ['sheets', 'physics', 'pieces', 'cuts', 'plots', 'states', 'people']) {
        await page.page.click(`[data-panel=${panel}]`);
        await audit(page.page, panel);
        await page.screenshot(`${name}-${colorScheme}-${panel}`);
        await page.page.click(`#panel-${panel} [data-close]`);
      }
      await auditDialogs(page);
      await auditStreams(page, `${name}-${colorScheme}`);
      await page.choose('cut');
      await audit(page.page, 'cut');
      await page.screenshot(`${name}-${colorScheme}-cut`);
      await page.page.click('[data-panel=sheets]');
      await page.page.click('#new-sheet-open');
      await audit(page.page, 'new sheet');
      await page.page.keyboard.press('Escape');
      const overflow = await page.page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
      check(overflow <= 0, `the page is ${overflow} px too wide`);
      check(page.errors.length === 0, `console: ${page.errors.join('; ')}`);
      await page.page.close();
    });
  }

  steps.step('two fingers move the view, whatever one finger would do', async () => {
    const phone = await open({ ...kPhone, colorScheme: 'light' });
    const pinch = async () => {
      const session = await phone.page.context().newCDPSession(phone.page);
      const touch = (type, ...touchPoints) => session.send('Input.dispatchTouchEvent', { type, touchPoints });
      const at = (x, id) => ({ x, y: 420, id });
      await touch('touchStart', at(180, 1));
      await touch('touchStart', at(180, 1), at(210, 2));
      for (let i = 1; i <= 6; ++i) await touch('touchMove', at(180 - 10 * i, 1), at(210 + 10 * i, 2));
      await touch('touchEnd');
      await session.detach();
    };
    const width = async () => {
      await phone.allDrawn();
      return (await phone.at(1, 0)).x - (await phone.at(0, 0)).x;
    };
    await phone.page.click('#controls-more');
    for (const tool of ['view', 'cut', 'grab', 'pin']) {
      await phone.choose(tool);
      if (tool === 'cut') await phone.page.click('#cut-panel [data-mode=freehand]');
      const before = await width();
      await pinch();
      check((await width()) > 1.2 * before, `with ${tool} a pinch took the sheet from ${before} px to ${await width()}`);
      if (tool === 'cut') check(await phone.page.isDisabled('#cut-cancel'), 'the first finger has left a drawing');
      await phone.page.click('#fit');
    }
    await phone.page.close();
    check(viewer.errors.length === 0, `console: ${viewer.errors.join('; ')}`);
    await viewer.page.close();
  });
}
