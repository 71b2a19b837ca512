// Tokens, links and rights in the viewer, with a kerfd that asks for them.
import { createServer } from 'node:http';
import { audit } from './axe.mjs';
import { GuardedServer } from './guarded_server.mjs';
import { check } from './harness.mjs';
import { ViewerPage } from './viewer_page.mjs';

const kScene = { grid: { columns: 11, rows: 11, widthM: 1, heightM: 1 }, gravityMps2: {} };
const kDesktop = { viewport: { width: 1280, height: 720 }, colorScheme: 'light', reducedMotion: 'reduce' };
const kPhone = { viewport: { width: 390, height: 844 }, colorScheme: 'dark', hasTouch: true, isMobile: true, reducedMotion: 'reduce' };

const kLive = 'k.connection === "live" && k.framesDrawn > 0';

export function loginSteps(steps, browser, server) {
  const gate = new GuardedServer(server);
  const all = gate.add('lab', 'admin');
  const look = gate.add('looker', 'view');
  let viewer;
  const open = (path, options = kDesktop) => ViewerPage.open(browser, `${gate.url}${path}`, options);
  const asks = ({ page }) => page.locator('#login[open]').waitFor();
  const give = async ({ page }, token) => {
    await page.fill('#login-token', token);
    await page.keyboard.press('Enter');
  };
  const enters = async (of, token) => {
    await give(of, token);
    await of.page.waitForSelector('#login', { state: 'hidden' });
  };
  const shown = ({ page }, ids) => page.evaluate((all) => all.filter((id) => document.querySelector(id).checkVisibility()), ids);

  steps.step('a page asks for a token, says why one is refused, and goes on with the right one', async () => {
    await gate.start();
    const made = await gate.post('lab', 'SheetService/CreateSheet', { sheetId: 'guarded', scene: kScene, paused: true });
    check(made.ok, `CreateSheet: ${made.status}`);
    viewer = await open('/?sheet=guarded');
    await asks(viewer);
    const focused = await viewer.page.evaluate(() => document.activeElement.id);
    check(focused === 'login-token', `the focus is at ${focused}`);
    check(await viewer.page.isHidden('#login-error'), 'a user who has just come is reproached');
    await audit(viewer.page, 'login');
    await viewer.screenshot('login');
    await give(viewer, 'kerf_lab_typo');
    await viewer.shows('#login-error', 'this server does not know the token; ask its operator for one');
    await enters(viewer, all);
    await viewer.untilDrawn(kLive);
    check((await viewer.page.evaluate(() => document.cookie)) === '', 'scripts can read the login');
  });

  steps.step('who is logged in, with which rights, is shown', async () => {
    const { page } = viewer;
    await page.click('[data-panel=access]');
    await viewer.shows('#access-token', 'lab');
    await viewer.shows('#access-scope', 'everything');
    await audit(page, 'access');
  });

  steps.step('a link lets others look, and its code leaves the address', async () => {
    const { page } = viewer;
    await page.selectOption('#share-lifetime', '3600');
    await page.click('#share-form [type=submit]');
    await page.waitForSelector('#share-made', { state: 'visible' });
    await audit(page, 'a link');
    await viewer.screenshot('access-link');
    const { pathname, search, hash } = new URL(await page.inputValue('#share-link'));
    const other = await open(`${pathname}${search}${hash}`);
    await other.untilDrawn(kLive);
    check(!other.page.url().includes('code'), `the address is ${other.page.url()}`);
    check(await other.page.isHidden('#login'), 'a link asks for a token');
    await other.page.click('[data-panel=access]');
    await other.shows('#access-scope', 'look only');
    await other.page.close();
    const late = await open(`${pathname}${search}${hash.slice(0, -1)}`);
    await asks(late);
    await late.shows('#login-error', 'this link has ended or was opened before; ask for a new one');
    check(!late.page.url().includes('code'), `the address is ${late.page.url()}`);
    await late.page.close();
  });

  steps.step('who may look has no control that changes or makes a sheet', async () => {
    const looking = await open('/?sheet=guarded');
    await asks(looking);
    await enters(looking, look);
    await looking.untilDrawn(kLive);
    const { page } = looking;
    const changing = ['[data-tool=cut]', '[data-tool=grab]', '[data-tool=pin]', '#pause', '#step', '#speed', '#reset', '#undo', '#redo'];
    const left = await shown(looking, changing);
    check(left.length === 0, `there are ${left}`);
    check((await shown(looking, ['#wireframe', '#save-open', '[data-tool=view]'])).length === 3, 'there is nothing to look with');
    await page.focus('#canvas');
    for (const key of ['Space', 'c']) {
      await page.keyboard.press(key);
      await looking.notice(/^You may look only/);
      await page.click('.notice');
    }
    check((await looking.read('k.tool')) === 'view' && (await looking.read('k.isPaused')), 'a key has changed something');
    await page.click('[data-panel=physics]');
    check(await page.isDisabled('#gravity'), 'gravity can be set');
    check(await page.isDisabled('#material-preset'), 'the material can be set');
    await audit(page, 'physics to look at');
    await looking.screenshot('login-look-only');
    await page.click('[data-panel=states]');
    check(await page.isDisabled('#state-form button'), 'a state can be saved');
    await page.click('[data-panel=sheets]');
    check((await shown(looking, ['#new-sheet-open', '#sheet-list .icon'])).length === 0, 'a sheet can be made or deleted');
    await page.close();
  });

  steps.step('a login that ends is asked for once, and the page goes on where it was', async () => {
    const { page } = viewer;
    await page.click('#panel-access [data-close]');
    await viewer.choose('cut');
    await page.evaluate(() => (window.notReloaded = true));
    await gate.withdraw('lab');
    await asks(viewer);
    await viewer.shows('#login-error', 'the token or login was withdrawn; log in with another one');
    await viewer.shows('#connection b', 'Logged out');
    await enters(viewer, all);
    await viewer.until('k.connection === "live"');
    await viewer.shows('#connection b', 'Live');
    check((await viewer.read('k.tool')) === 'cut', 'the tool is another');
    await page.keyboard.press('Space');
    await viewer.until('!k.isPaused');
    check(await page.evaluate(() => window.notReloaded), 'the page was loaded again');
    check(await page.isHidden('#login'), 'the login is asked for twice');
  });

  steps.step('the login can be put off, and be done later', async () => {
    const { page } = viewer;
    await gate.withdraw('lab');
    await asks(viewer);
    await page.keyboard.press('Escape');
    await page.waitForSelector('[data-tool=cut]', { state: 'hidden' });
    check((await viewer.read('k.tool')) === 'view', 'the cut tool is still chosen');
    await page.click('[data-panel=access]');
    await audit(page, 'access without a login');
    await page.click('#log-in');
    await enters(viewer, all);
    await viewer.until('k.connection === "live"');
    await page.waitForSelector('[data-tool=cut]', { state: 'visible' });
  });

  steps.step('a token that has ended is refused with its reason', async () => {
    await gate.expire('lab');
    await asks(viewer);
    await give(viewer, all);
    await viewer.shows('#login-error', 'the token or login has expired; log in with a newer one');
    await gate.renew('lab');
    await enters(viewer, all);
    await viewer.until('k.connection === "live"');
  });

  steps.step('a page of another server on this machine can do nothing with the login', async () => {
    const sceneTick = async () => {
      const answer = await gate.post('lab', 'SheetService/GetSheet', { name: 'sheets/guarded' });
      return Number((await answer.json()).scene_tick);
    };
    const foreign = createServer((request, response) => response.setHeader('content-type', 'text/html').end('<p>elsewhere'));
    await new Promise((listening) => foreign.listen(0, '127.0.0.1', listening));
    const before = await sceneTick();
    const context = await browser.newContext(kDesktop);
    const own = await ViewerPage.open(context, `${gate.url}/?sheet=guarded`, {});
    await asks(own);
    await enters(own, all);
    const page = await context.newPage();
    await page.goto(`http://127.0.0.1:${foreign.address().port}/`);
    const tried = await page.evaluate(async (url) => {
      const body = JSON.stringify({ name: 'sheets/guarded' });
      const asks = (headers) =>
        fetch(`${url}/kerf.v1.SheetService/ResetSheet`, { method: 'POST', body, credentials: 'include', headers }).then(
          ({ status }) => status,
          () => 'no answer',
        );
      const socket = new WebSocket(`${url.replace('http', 'ws')}/watch`, 'kerf.v1');
      const watched = new Promise((ended) => {
        socket.onopen = () => ended('open');
        socket.onclose = () => ended('no answer');
      });
      return [await asks({}), await asks({ 'x-kerf-csrf': '1' }), await watched];
    }, gate.url);
    check(tried.every((answer) => answer === 'no answer'), `it was answered: ${tried}`);
    check(before > 0 && (await sceneTick()) >= before, 'the sheet was reset');
    await context.close();
    foreign.close();
    foreign.closeAllConnections();
  });

  steps.step('a logout begins the page again, and reaches other tabs', async () => {
    await viewer.page.close();
    // Two tabs of one browser.
    const context = await browser.newContext(kDesktop);
    const tabs = [];
    for (let i = 0; i < 2; ++i) {
      tabs.push(await ViewerPage.open(context, `${gate.url}/?sheet=guarded`, {}));
      if (i === 0) {
        await asks(tabs[i]);
        await enters(tabs[i], all);
      }
      await tabs[i].untilDrawn(kLive);
    }
    const [one, other] = tabs;
    await one.page.evaluate(() => (window.notReloaded = true));
    await one.page.click('[data-panel=access]');
    await one.page.click('#log-out');
    await one.page.waitForFunction(() => window.notReloaded === undefined);
    for (const tab of tabs) await asks(tab);
    await enters(one, all);
    await one.untilDrawn(kLive);
    // The other tab finds that out when it is shown.
    await other.page.evaluate(() => document.dispatchEvent(new Event('visibilitychange')));
    await other.page.waitForSelector('#login', { state: 'hidden' });
    await other.until('k.connection === "live"');
    await context.close();
  });

  steps.step('axe finds nothing on a phone in the dark, with the login and with a link', async () => {
    const phone = await open('/?sheet=guarded', kPhone);
    const { page } = phone;
    await asks(phone);
    await audit(page, 'login on a phone');
    await phone.picture('phone-login');
    await enters(phone, look);
    await phone.untilDrawn(kLive);
    await audit(page, 'looking on a phone');
    await phone.picture('phone-look-only');
    await page.click('[data-panel=access]');
    await page.click('#share-form [type=submit]');
    await page.waitForSelector('#share-made', { state: 'visible' });
    await audit(page, 'access on a phone');
    await phone.picture('phone-access');
    const overflow = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
    check(overflow <= 0, `the page is ${overflow} px too wide`);
    await page.close();
    await gate.stop();
  });
}
