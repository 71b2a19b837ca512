// The viewer on slow networks, beside other viewers, unseen, and when the server goes and comes back.
import { check, post, root } from './harness.mjs';
import { startSlowProxy } from './slow_proxy.mjs';
import { ViewerPage } from './viewer_page.mjs';

// Small, for it is drawn in software.
const kSmall = { viewport: { width: 760, height: 480 }, colorScheme: 'light' };
const kMedium = { viewport: { width: 900, height: 640 }, colorScheme: 'light' };
const kDemo = { name: 'sheets/demo' };
const kTickRateHz = 60;
// The window that the server never exceeds.
const kLargestWindow = 8;

const kSlow = { name: 'sheets/slow' };
const kSwinging = {
  grid: { columns: 31, rows: 31, widthM: 1, heightM: 1 },
  placement: { xAxis: { x: 1 }, yAxis: { y: 1 } },
  pins: [{ nearest: { x: 0, y: 1 } }, { nearest: { x: 1, y: 1 } }],
};

// Nothing moves it: what is drawn on it is where it was meant.
const kStill = {
  grid: { columns: 31, rows: 31, widthM: 1, heightM: 1 },
  placement: { xAxis: { x: 1 }, yAxis: { y: Math.cos(0.7), z: Math.sin(0.7) } },
  gravityMps2: {},
};

async function serverTick(url, sheet) {
  return Number((await post(url, 'SheetService/GetSheet', sheet)).tick ?? 0);
}

/** Returns by how many ticks the shown sheet is behind the server, ascending, seen `count` times, each a frame or more apart. */
async function lags(viewer, url, sheet, count) {
  const found = [];
  for (let i = 0; i < count; ++i) {
    const shown = await viewer.read('k.tick');
    await viewer.until('k.tick > given.shown', { shown });
    // The server's tick first: what is shown may only be newer by the time that it is read.
    const now = await serverTick(url, sheet);
    found.push(now - (await viewer.read('k.tick')));
  }
  return found.sort((a, b) => a - b);
}

async function slowNetwork(browser, server) {
  const kDelayMs = 150;
  // Half of what every tick would take.
  const kBytesPerS = 90_000;
  const limits = { delayMs: 0, bytesPerS: 1e9 };
  const proxy = await startSlowProxy(server.url, limits);
  await post(server.url, 'SheetService/CreateSheet', { sheetId: 'slow', scene: kSwinging });
  // Drawing as often as it can, the page leaves the number of frames to the network.
  const viewer = await ViewerPage.open(browser, `${proxy.url}/?sheet=slow`, { ...kSmall, frameMs: 0 });
  await viewer.untilDrawn('k.connection === "live" && k.framesDrawn > 0');
  // The page is loaded by now; its program alone would take ten seconds at this speed.
  Object.assign(limits, { delayMs: kDelayMs, bytesPerS: kBytesPerS });
  await viewer.until('k.framesDrawn > given.drawn + 5', { drawn: await viewer.read('k.framesDrawn') });
  const begin = await serverTick(server.url, kSlow);
  await viewer.page.keyboard.press('u');
  // Five seconds of ticks: were frames queued, they would be later and later.
  await viewer.until('k.tick > given.begin + 300', { begin });
  const behind = await lags(viewer, server.url, kSlow, 7);
  const { mostInFlight, sent } = proxy.count('/watch');
  const passed = (await serverTick(server.url, kSlow)) - begin;
  const roundTripTicks = (2 * kDelayMs * kTickRateHz) / 1000;
  const median = behind[behind.length >> 1];
  console.log(
    `         ${sent} frames of ${passed} ticks, at most ${mostInFlight} in flight; shown ${behind[0]} to ` +
      `${behind.at(-1)} ticks behind, median ${median}; a round trip is ${roundTripTicks} ticks`,
  );
  // All that can be between the server's newest tick and the one shown.
  check(mostInFlight <= kLargestWindow, `${mostInFlight} frames were in flight`);
  // A round trip and a frame, and a frame for the page to draw it; a queue as long as the window would be several times that.
  const most = roundTripTicks + (2 * passed) / sent;
  check(median <= most, `in the median ${median} ticks behind, not ${most.toFixed(0)}`);
  check(sent < passed, `all of ${passed} ticks were sent over a network that cannot carry them`);
  await viewer.screenshot('slow-network');
  check(viewer.errors.length === 0, `console: ${viewer.errors.join('; ')}`);
  await viewer.page.close();
  await proxy.stop();
  await post(server.url, 'SheetService/DeleteSheet', kSlow);
}

async function twoBrowsers(browser, server) {
  const parent = 'sheets/shared';
  await post(server.url, 'SheetService/CreateSheet', { sheetId: 'shared', scene: kStill });
  const viewers = await Promise.all(
    [0, 1].map(() => ViewerPage.open(browser, `${server.url}/?sheet=shared`, kMedium)),
  );
  await Promise.all(viewers.map((viewer) => viewer.untilDrawn('k.connection === "live" && k.framesDrawn > 0')));
  const { version: uncut } = await viewers[0].read('({ version: k.topologyVersion })');
  // Each cuts lines of its own, as fast as it can draw them, while the other does.
  await Promise.all(
    viewers.map(async (viewer, i) => {
      await viewer.choose('cut');
      for (let line = 0; line < 3; ++line) {
        await viewer.page.keyboard.press('5');
        await viewer.page.keyboard.press('i');
        // These points lie above the panel.
        const x = 0.15 + 0.25 * line + 0.1 * i;
        await viewer.tap(x, 0.5 + 0.02 * line);
        await viewer.tap(x + 0.05, 0.95);
        const areShown = (count) => document.querySelectorAll('.handle:not([hidden])').length === count;
        await viewer.page.waitForFunction(areShown, 2);
        await viewer.page.keyboard.press('Enter');
        // The drawing goes when its cut is made.
        await viewer.page.waitForFunction(areShown, 0);
      }
    }),
  );
  for (const viewer of viewers) await viewer.until('k.topologyVersion >= given.uncut + 6', { uncut });
  const { cuts } = await post(server.url, 'CutService/ListCuts', { parent });
  check(cuts.length === 6, `${cuts.length} cuts were made, not 6`);
  const { topology_version: version } = await post(server.url, 'SheetService/GetSheet', { name: parent });
  for (const viewer of viewers) await viewer.until('k.topologyVersion === given.version', { version });
  const hashes = [];
  for (const viewer of viewers) hashes.push(await viewer.read('k.meshHash'));
  // One that has seen none of the cuts gets the whole mesh at once.
  const late = await ViewerPage.open(browser, `${server.url}/?sheet=shared`, kMedium);
  await late.until('k.topologyVersion === given.version', { version });
  hashes.push(await late.read('k.meshHash'));
  check(new Set(hashes).size === 1 && hashes[0] !== '', `mesh hashes ${hashes}`);
  // It is at rest: nothing more is drawn.
  await viewers[1].page.screenshot({ path: `${root}/build/e2e/two-browsers.png` });
  for (const { page } of [...viewers, late]) await page.close();
  await post(server.url, 'SheetService/DeleteSheet', { name: parent });
}

async function hiddenTab(browser, server) {
  const proxy = await startSlowProxy(server.url, { delayMs: 0, bytesPerS: 1e9 });
  const viewer = await ViewerPage.open(browser, `${proxy.url}/?sheet=demo`, kSmall);
  await viewer.untilDrawn('k.connection === "live" && k.framesDrawn > 5');
  await viewer.setHidden(true);
  // The pause reaches the server, and what was on its way arrives.
  const quiet = async () => {
    const { sent } = proxy.count('/watch');
    const tick = await serverTick(server.url, kDemo);
    while ((await serverTick(server.url, kDemo)) < tick + 60);
    return proxy.count('/watch').sent === sent;
  };
  let tries = 0;
  while (!(await quiet())) check(++tries < 10, 'frames go on coming to a page that nobody sees');
  const tick = await viewer.read('k.tick');
  check((await viewer.read('k.connection')) === 'live', 'the connection is gone');
  await viewer.setHidden(false);
  await viewer.until('k.tick > given.tick + 60', { tick });
  await viewer.page.close();
  await proxy.stop();
}

async function restart(browser, server) {
  const viewer = await ViewerPage.open(browser, `${server.url}/?sheet=demo`, kSmall);
  await viewer.untilDrawn('k.connection === "live" && k.framesDrawn > 5');
  await viewer.page.evaluate(() => (window.notReloaded = true));
  await server.stop();
  await viewer.until('k.connection === "lost"');
  await server.start();
  await viewer.until('k.connection === "live" && k.numVertices === 2500 && k.pieces === 1');
  await viewer.notice(/The server was restarted, or the sheet created again/);
  const tick = await viewer.read('k.tick');
  await viewer.until('k.tick > given.tick', { tick });
  check(await viewer.page.evaluate(() => window.notReloaded), 'the page was loaded again');
  const fresh = await ViewerPage.open(browser, `${server.url}/?sheet=demo`, kSmall);
  await fresh.untilDrawn('k.connection === "live" && k.framesDrawn > 0');
  // Steps one tick: the scene has a cut to come.
  await post(server.url, 'SheetService/PauseSheet', kDemo);
  const last = await serverTick(server.url, kDemo);
  for (const page of [viewer, fresh]) await page.until('k.tick === given.last', { last });
  const hashes = [await viewer.read('k.meshHash'), await fresh.read('k.meshHash')];
  check(hashes[0] === hashes[1], `after the restart the page has mesh ${hashes[0]}, a new one ${hashes[1]}`);
  for (const { page } of [viewer, fresh]) await page.close();
  await post(server.url, 'SheetService/ResumeSheet', kDemo);
}

async function withoutWorkers(browser, server) {
  const viewer = await ViewerPage.open(browser, server.url, kSmall, (page) =>
    page.route('**/*_worker*', (route) => route.abort()),
  );
  await viewer.until('k.connection === "ended"');
  await viewer.shows('#connection b', 'Ended');
  await viewer.notice(/The viewer can no longer receive the sheet: its program cannot be loaded/);
  const file = { name: 'any.kerfstream', mimeType: '', buffer: Buffer.from('any') };
  await viewer.page.setInputFiles('#replay-file', file);
  await viewer.notice(/any.kerfstream cannot be played: the player failed/);
  check(await viewer.page.isHidden('#replay'), 'the progress of a file that nobody reads is still there');
  await viewer.page.keyboard.press('q');
  await viewer.notice(/No pictures, so the mesh is shown: the decoder failed/);
  await viewer.page.close();
}

/** A reset by one of two who watch. */
async function resetBeforeOthers(browser, server) {
  await post(server.url, 'SheetService/CreateSheet', { sheetId: 'shared', scene: kStill, paused: true });
  const pages = [];
  for (let i = 0; i < 2; ++i) {
    pages.push(await ViewerPage.open(browser, `${server.url}/?sheet=shared`, kSmall));
    await pages[i].untilDrawn('k.connection === "live" && k.framesDrawn > 0');
  }
  const [first, second] = pages;
  const curve = { polyline: { points: [{ x: -0.1, y: 0.4 }, { x: 1.1, y: 0.6 }] } };
  await post(server.url, 'CutService/CreateCut', { parent: 'sheets/shared', cut: { curve } });
  for (const page of pages) await page.until('k.pieces === 2');
  await first.page.click('#reset');
  await first.shows('#confirmation-question', 'Someone else is watching this sheet. Reset it for everyone?');
  await first.page.keyboard.press('Escape');
  await first.page.waitForSelector('#confirmation', { state: 'hidden' });
  check((await first.read('k.pieces')) === 2, 'a reset that was not confirmed was done');
  await first.page.click('#reset');
  await first.page.click('#confirmation-yes');
  for (const page of pages) {
    await page.until('k.pieces === 1');
    await page.notice(/The sheet was reset; Undo brings back what was there/);
  }
  await second.page.keyboard.press('Control+z');
  for (const page of pages) {
    await page.until('k.pieces === 2');
    await page.notice(/The reset was undone/);
    await page.page.close();
  }
  await post(server.url, 'SheetService/DeleteSheet', { name: 'sheets/shared' });
}

/** A scene that plays again by itself while it is watched, until a client changes it. */
async function story(browser, server) {
  const curve = { polyline: { points: [{ x: -0.1, y: 0.4 }, { x: 1.1, y: 0.6 }] } };
  const scene = { ...kStill, commands: [{ tick: 60, command: { cut: { curve } } }], repeatAfterTicks: 100 };
  await post(server.url, 'SheetService/CreateSheet', { sheetId: 'story', scene });
  const viewer = await ViewerPage.open(browser, `${server.url}/?sheet=story`, kSmall);
  for (let i = 0; i < 2; ++i) {
    await viewer.until('k.pieces === 2');
    await viewer.until('k.pieces === 1');
  }
  const second = { polyline: { points: [{ x: -0.1, y: 0.8 }, { x: 1.1, y: 0.9 }] } };
  await post(server.url, 'CutService/CreateCut', { parent: 'sheets/story', cut: { curve: second } });
  await viewer.until('k.pieces === 3');
  const { tick } = await post(server.url, 'SheetService/GetSheet', { name: 'sheets/story' });
  while ((await post(server.url, 'SheetService/GetSheet', { name: 'sheets/story' })).run_state !== 'SLEEPING');
  const asleep = await post(server.url, 'SheetService/GetSheet', { name: 'sheets/story' });
  check(Number(asleep.tick) > Number(tick) && asleep.pieces === 3, `what was changed was taken away: ${asleep.pieces} pieces`);
  await viewer.page.close();
  await post(server.url, 'SheetService/DeleteSheet', { name: 'sheets/story' });
}

async function firstVisit(browser, server) {
  const viewer = await ViewerPage.open(browser, `${server.url}/?sheet=demo`, { ...kSmall, isFirstVisit: true });
  await viewer.page.waitForSelector('#first-hint', { state: 'visible' });
  await viewer.screenshot('first-hint');
  await viewer.page.keyboard.press('c');
  await viewer.page.waitForSelector('#first-hint', { state: 'hidden' });
  await viewer.page.reload();
  await viewer.until('k.connection === "live"');
  check(await viewer.page.isHidden('#first-hint'), 'the hint is there again');
  await viewer.page.close();
}

export function connectionSteps(steps, browser, server) {
  steps.step('a first visit has a hint, a second one has not', () => firstVisit(browser, server));
  steps.step('a reset is confirmed where others watch, told to everybody and undone', () =>
    resetBeforeOthers(browser, server),
  );
  steps.step('a scene that repeats plays again while it is watched, until a client changes it', () =>
    story(browser, server),
  );
  steps.step('on a slow network frames are skipped, and no more are on their way than a window has', () =>
    slowNetwork(browser, server),
  );
  steps.step('two browsers that cut one sheet at once end with the same mesh', () => twoBrowsers(browser, server));
  steps.step('a page that nobody sees gets no frames, and goes on when it is seen', () =>
    hiddenTab(browser, server),
  );
  steps.step('a worker that cannot be loaded is told, not waited for', () => withoutWorkers(browser, server));
  steps.step('after a restart of the server the page goes on with its sheets, without a reload', () =>
    restart(browser, server),
  );
}
