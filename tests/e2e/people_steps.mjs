// Who watches a sheet, what they do and where they point, with several pages on a kerfd that asks for tokens.
import { audit } from './axe.mjs';
import { GuardedServer } from './guarded_server.mjs';
import { check, kPatienceMs } from './harness.mjs';
import { ViewerPage } from './viewer_page.mjs';

const kScene = {
  grid: { columns: 21, rows: 21, widthM: 1, heightM: 1 },
  placement: { origin: { x: -0.5, z: 0.2 }, xAxis: { x: 1 }, yAxis: { y: Math.cos(0.7), z: Math.sin(0.7) } },
  gravityMps2: {},
};
const kDesktop = { viewport: { width: 1280, height: 720 }, colorScheme: 'light', reducedMotion: 'reduce' };
const kPhone = { viewport: { width: 390, height: 844 }, colorScheme: 'dark', hasTouch: true, isMobile: true, reducedMotion: 'reduce' };
const kLive = 'k.connection === "live" && k.framesDrawn > 0';

export function peopleSteps(steps, browser, server) {
  const gate = new GuardedServer(server);
  const lab = gate.add('lab', 'admin');
  const ann = gate.add('ann', 'view');
  gate.add('bob', 'cut');
  let viewer;
  let guest;

  const enter = async (token, options = kDesktop) => {
    const opened = await ViewerPage.open(browser, `${gate.url}/?sheet=people`, options);
    await opened.page.locator('#login[open]').waitFor();
    await opened.page.fill('#login-token', token);
    await opened.page.keyboard.press('Enter');
    await opened.untilDrawn(kLive);
    return opened;
  };
  // Lines of a list with their parts: names, marks, rights, times.
  const linesOf = ({ page }, id) =>
    page.$$eval(`#${id} li`, (lines) =>
      lines.map(({ children }) => [...children].map((part) => part.textContent).filter(Boolean).join('|')),
    );
  // Waits until a list has these lines.
  const lists = async (of, id, wanted) => {
    const end = Date.now() + kPatienceMs;
    for (;;) {
      const lines = await linesOf(of, id);
      if (lines.join('\n') === wanted.join('\n')) return;
      check(Date.now() < end, `#${id} has ${JSON.stringify(lines)}, not ${JSON.stringify(wanted)}`);
      await of.allDrawn();
    }
  };
  // Waits until the newest change is this one.
  const reads = ({ page }, what) =>
    page.waitForFunction((text) => document.querySelector('#people-changes span')?.textContent === text, what).catch(async (error) => {
      throw new Error(`the changes are ${await page.textContent('#people-changes')}, not ${what} at first: ${error.message}`);
    });
  // Waits until the other's dot is at a point of the sheet.
  const dotIsAt = async ({ page }, name, x, y) => {
    const isThere = ([text, materialX, materialY]) => {
      const dot = [...document.querySelectorAll('.pointer-dot')].find(({ textContent }) => textContent === text);
      const at = window.kerf.toClient(materialX, materialY);
      if (!dot?.checkVisibility() || !at) return false;
      const { x, y, width, height } = dot.getBoundingClientRect();
      return Math.hypot(x + width / 2 - at.x, y + height / 2 - at.y) < 2;
    };
    await page.waitForFunction(isThere, [name, x, y]).catch((error) => {
      throw new Error(`no dot of ${name} at (${x}, ${y}): ${error.message}`);
    });
  };
  // A page that asks for a token has been refused first.
  const checkConsole = ({ errors }) => {
    const others = errors.filter((error) => !error.includes('401'));
    check(others.length === 0, `console: ${others.join('; ')}`);
  };
  const hasNoDot = ({ page }) => page.locator('.pointer-dot').waitFor({ state: 'detached' });
  const pointAt = async (of, x, y) => {
    const { x: left, y: top } = await of.at(x, y);
    await of.page.mouse.move(left, top);
  };

  steps.step('a user who is alone finds out, and makes a link from there', async () => {
    await gate.start();
    const made = await gate.post('lab', 'SheetService/CreateSheet', { sheetId: 'people', scene: kScene, paused: true });
    check(made.ok, `CreateSheet: ${made.status}`);
    viewer = await enter(lab);
    const { page } = viewer;
    check(await page.isHidden('#people-count'), 'others are counted');
    await page.click('[data-panel=people]');
    await viewer.shows('#people-summary', 'You are alone here.');
    await lists(viewer, 'people-list', ['lab|you|everything']);
    await page.focus('#people-share');
    await page.keyboard.press('Enter');
    await page.waitForSelector('#panel-access', { state: 'visible' });
    check(await page.evaluate(() => document.activeElement.id === 'share-scope'), 'the focus is not in the form');
    await page.selectOption('#share-scope', '2');
    await page.click('#share-form [type=submit]');
    await page.waitForSelector('#share-made', { state: 'visible' });
    const { pathname, search, hash } = new URL(await page.inputValue('#share-link'));
    guest = await ViewerPage.open(browser, `${gate.url}${pathname}${search}${hash}`, kDesktop);
    await guest.untilDrawn(kLive);
  });

  steps.step('both see the other, and the count also with a closed panel', async () => {
    const { page } = viewer;
    await viewer.shows('#people-count', '1 other');
    await viewer.shows('#people-joined', 'guest of lab has joined');
    await page.click('[data-panel=people]');
    await viewer.shows('#people-summary', 'You and 1 other watch this sheet.');
    await lists(viewer, 'people-list', ['lab|you|everything', 'guest of lab|look and cut']);
    await guest.page.click('[data-panel=people]');
    await lists(guest, 'people-list', ['guest of lab|you|look and cut', 'lab|everything']);
    await audit(page, 'people');
  });

  steps.step('one cuts, and the other reads who did it', async () => {
    const { keyboard } = guest.page;
    await guest.page.focus('#canvas');
    await keyboard.press('c');
    await keyboard.press('i');
    await guest.tap(-0.1, 0.5);
    await guest.tap(1.1, 0.5);
    await keyboard.press('Enter');
    await viewer.until('k.pieces === 2');
    for (const each of [viewer, guest]) await reads(each, 'guest of lab cut the sheet');
    await viewer.page.click('#undo');
    for (const each of [viewer, guest]) await reads(each, 'lab undid a change');
    // Also a program does that, which does not watch.
    for (const z of [-1, -2, 0]) {
      const set = await gate.post('bob', 'InteractionService/SetSheetGravity', { name: 'sheets/people', setGravity: { gravityMps2: { z } } });
      check(set.ok, `SetSheetGravity: ${set.status}`);
    }
    await reads(viewer, 'bob changed gravity 3 times');
    await viewer.screenshot('people-light');
    await keyboard.press('v');
  });

  steps.step('a page that comes later reads what was done before', async () => {
    const late = await enter(ann);
    await late.page.click('[data-panel=people]');
    await reads(late, 'bob changed gravity 3 times');
    await lists(late, 'people-list', ['ann|you|look only', 'lab|everything', 'guest of lab|look and cut']);
    await viewer.shows('#people-count', '2 others');
    await late.page.close();
    await viewer.shows('#people-count', '1 other');
  });

  steps.step('where one points is seen by the other, and follows the sheet', async () => {
    await guest.page.click('#pointing');
    check((await guest.page.getAttribute('#pointing', 'aria-pressed')) === 'true', 'the button is not pressed');
    await pointAt(guest, 0.25, 0.75);
    await dotIsAt(viewer, 'guest of lab', 0.25, 0.75);
    await dotIsAt(guest, '', 0.25, 0.75);
    await viewer.screenshot('people-pointer');
    // With the view, and with the sheet.
    await viewer.page.focus('#canvas');
    await viewer.page.keyboard.press('ArrowLeft');
    await viewer.allDrawn();
    await dotIsAt(viewer, 'guest of lab', 0.25, 0.75);
    await guest.page.mouse.move(...Object.values(await guest.at(0.75, 0.25)), { steps: 10 });
    await dotIsAt(viewer, 'guest of lab', 0.75, 0.25);
    await guest.page.hover('#header');
    await hasNoDot(viewer);
    await hasNoDot(guest);
  });

  steps.step('who may look only points, too, until the key is pressed again or the page is closed', async () => {
    const other = await enter(ann);
    await other.page.focus('#canvas');
    await other.page.keyboard.press('z');
    await pointAt(other, 0.5, 0.5);
    for (const each of [viewer, guest]) await dotIsAt(each, 'ann', 0.5, 0.5);
    await other.page.keyboard.press('z');
    for (const each of [viewer, guest]) await hasNoDot(each);
    await other.page.keyboard.press('z');
    for (const each of [viewer, guest]) await dotIsAt(each, 'ann', 0.5, 0.5);
    await other.page.close();
    for (const each of [viewer, guest]) await hasNoDot(each);
    checkConsole(other);
  });

  steps.step('another stream of the same page begins with all of it', async () => {
    const changes = await linesOf(viewer, 'people-changes');
    await viewer.page.keyboard.press('x');
    await viewer.until('k.numStrains > 0');
    await viewer.shows('#people-count', '1 other');
    await lists(viewer, 'people-changes', changes);
    await lists(guest, 'people-list', ['guest of lab|you|look and cut', 'lab|everything']);
    check((await guest.page.textContent('#people-joined')) !== 'lab has joined', 'who was there is said to have joined');
  });

  steps.step('axe finds nothing on a phone in the dark', async () => {
    const phone = await enter(ann, kPhone);
    await phone.shows('#people-count', '2 others');
    await phone.picture('phone-people-closed');
    await phone.page.click('[data-panel=people]');
    // The stream of the first page has begun again since.
    await lists(phone, 'people-list', ['ann|you|look only', 'guest of lab|look and cut', 'lab|everything']);
    await audit(phone.page, 'people on a phone');
    await phone.picture('phone-people');
    const overflow = await phone.page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
    check(overflow <= 0, `the page is ${overflow} px too wide`);
    await phone.page.close();
  });

  steps.step('who leaves is gone from the list', async () => {
    await lists(viewer, 'people-list', ['lab|you|everything', 'guest of lab|look and cut']);
    await guest.page.close();
    await lists(viewer, 'people-list', ['lab|you|everything']);
    await viewer.page.waitForSelector('#people-count', { state: 'hidden' });
    await viewer.shows('#people-summary', 'You are alone here.');
    checkConsole(viewer);
    await viewer.page.close();
    await gate.stop();
  });
}
