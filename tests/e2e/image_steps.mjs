// Pictures that the server draws in place of the mesh, in Chromium against a real kerfd.
import { writeFile } from 'node:fs/promises';
import { check, post, root } from './harness.mjs';
import { bareColours, changes, coloursOnce, decodesVp8, distance, enter, isInPlace, savedPng, settle } from './image_page.mjs';
import { startSlowProxy } from './slow_proxy.mjs';
import { ViewerPage } from './viewer_page.mjs';

// Small, for it is drawn in software twice; wide enough for nothing to lie over the sheet where it is looked at.
const kSmall = { viewport: { width: 760, height: 480 }, colorScheme: 'light' };
const kWide = { viewport: { width: 900, height: 640 }, colorScheme: 'light' };
const kSeen = { name: 'sheets/seen' };
// Nothing moves it: what is cut out stays where it was, and each place is where it is expected. Silk is red, and the page is
// nowhere red.
const kStill = {
  grid: { columns: 31, rows: 31, widthM: 1, heightM: 1 },
  material: { preset: 'silk' },
  fidelity: 'REAL_TIME',
  placement: { xAxis: { x: 1 }, yAxis: { y: Math.cos(0.7), z: Math.sin(0.7) } },
  gravityMps2: {},
};

// Not of the mesh's tick, which is up to a second older.
async function isNamedByTick(viewer) {
  const { tick: first } = await viewer.read('k.picture');
  const { name } = await savedPng(viewer);
  const { tick: last } = await viewer.read('k.picture');
  const tick = Number(/^demo-(\d+)\.png$/.exec(name)[1]);
  check(first <= tick && tick <= last, `a picture of a tick from ${first} to ${last} is called ${name}`);
}

/** Looks again where the sheet has left the place that the mesh gave: the mesh is up to a second older than the picture. */
async function showsCloth(viewer) {
  for (let tries = 0; ; ++tries) {
    const [cloth, sky] = await viewer.colours([await viewer.at(0.5, 0.3), { x: 380, y: 4 }], 'image-mode-demo');
    if (distance(cloth, sky) > 25) return;
    check(tries < 20, `the cloth is ${cloth}, the sky ${sky}`);
  }
}

async function takesThePlace(browser, server) {
  const proxy = await startSlowProxy(server.url, { delayMs: 0, bytesPerS: 1e9 });
  const viewer = await ViewerPage.open(browser, `${proxy.url}/?sheet=demo`, kSmall);
  await viewer.untilDrawn('k.connection === "live" && k.framesDrawn > 5');
  await viewer.screenshot('image-mode-before');
  await viewer.page.keyboard.press('u');
  await enter(viewer);
  const expected = (await decodesVp8(viewer.page)) ? 'IMAGE_VP8' : 'IMAGE_JPEG';
  const { codec, width, height } = await viewer.read('k.picture');
  check(codec === expected, `this Chromium should get ${expected}, not ${codec}`);
  check(width === 760 && height === 480, `pictures of ${width} x ${height}`);
  check((await viewer.page.getAttribute('#image-mode', 'aria-pressed')) === 'true', 'the button does not look pressed');
  const label = expected === 'IMAGE_VP8' ? 'VP8, 760 × 480' : 'JPEG, 760 × 480';
  await viewer.page.waitForFunction(
    (text) => [...document.querySelectorAll('#statistics dd')].some((value) => value.textContent === text),
    label,
  );
  // The pictures continue, and the mesh comes once a second at most.
  const meshBefore = proxy.count('/watch').sent;
  const [startMs, { tick, numShown }] = [performance.now(), await viewer.read('k.picture')];
  await viewer.until('k.picture.tick > given.tick + 90 && k.picture.numShown > given.numShown + 10', { tick, numShown });
  const meshes = proxy.count('/watch').sent - meshBefore;
  const seconds = (performance.now() - startMs) / 1000;
  const { sent, mostInFlight } = proxy.count('/images');
  console.log(`         ${sent} pictures, at most ${mostInFlight} in flight; beside them ${meshes} meshes in ${seconds.toFixed(1)} s`);
  check(meshes <= seconds + 2, `${meshes} frames of the mesh in ${seconds} s`);
  check(mostInFlight <= 8, `${mostInFlight} pictures were in flight`);
  const shown = Number((await viewer.page.textContent('#status-tick')).replaceAll(',', ''));
  check(shown > tick + 90, `the status line says tick ${shown}, the picture was at ${tick} before 90 more`);
  await showsCloth(viewer);
  await isNamedByTick(viewer);
  check(viewer.errors.length === 0, `console: ${viewer.errors.join('; ')}`);
  await viewer.page.close();
  await proxy.stop();
}

async function followsCamera(viewer) {
  await enter(viewer);
  await settle(viewer);
  await isInPlace(viewer, 'image-mode-view');
  await changes(viewer, async () => {
    await viewer.drag({ x: 120, y: 400 }, { x: 250, y: 350 });
    await viewer.page.mouse.up();
  });
  await settle(viewer);
  await isInPlace(viewer, 'image-mode-orbit');
  for (let i = 0; i < 3; ++i) await viewer.page.keyboard.press('-');
  await settle(viewer);
  await isInPlace(viewer, 'image-mode-zoom');
  for (const key of ['ArrowLeft', 'ArrowUp', 'Shift+ArrowRight']) await viewer.page.keyboard.press(key);
  await settle(viewer);
  await isInPlace(viewer, 'image-mode-keys');
  // Straight from above, as far as the camera goes.
  await viewer.drag({ x: 120, y: 60 }, { x: 120, y: 620 });
  await viewer.page.mouse.up();
  await settle(viewer);
  await isInPlace(viewer, 'image-mode-above');
  await viewer.page.keyboard.press('f');
  await settle(viewer);
}

async function followsWindow(viewer) {
  for (const [width, height] of [
    [801, 560],
    [900, 640],
  ]) {
    await viewer.page.setViewportSize({ width, height });
    await viewer.until('k.picture.width === given.width && k.picture.height === given.height && k.picture.isOfView', {
      width: 2 * Math.floor(width / 2),
      height,
    });
  }
  await viewer.page.keyboard.press('f');
  await settle(viewer);
  await isInPlace(viewer, 'image-mode-resized');
}

async function showsCuts(viewer, url) {
  await changes(viewer, () => viewer.page.keyboard.press('k'));
  const places = async () => [await viewer.at(0.5, 0.5), await viewer.at(0.5, 0.2), await viewer.at(0.2, 0.8)];
  const areAlike = ([disc, cloth]) => distance(disc, cloth) < 25;
  await coloursOnce(viewer, await places(), 'image-mode-uncut', areAlike, 'one piece has colours');
  const cut = { curve: { circle: { center: { x: 0.5, y: 0.5 }, radiusM: 0.12 } } };
  await post(url, 'CutService/CreateCut', { parent: kSeen.name, cut });
  const { tick } = await post(url, 'SheetService/GetSheet', kSeen);
  await viewer.until('k.picture.tick >= given.tick', { tick: Number(tick) });
  const differs = ([disc, rest]) => distance(disc, rest) > 40;
  await coloursOnce(viewer, await places(), 'image-mode-cut', differs, 'the disc and the rest are');
  // Tools work on what the picture shows.
  await viewer.choose('cut');
  await viewer.page.keyboard.press('o');
  await viewer.until('k.pieces === 2');
  await viewer.drag(await viewer.at(0.2, 0.8), await viewer.at(0.28, 0.8));
  await viewer.page.mouse.up();
  await viewer.page.screenshot({ path: `${root}/build/e2e/image-mode-drawing.png` });
  await viewer.page.keyboard.press('Enter');
  await viewer.until('k.pieces === 3');
  await viewer.choose('view');
  await viewer.shows('#status-pieces', '3');
  const isApart = ([, rest, second]) => distance(second, rest) > 40;
  await coloursOnce(viewer, await places(), 'image-mode-cut-here', isApart, 'the disc, the rest and the disc drawn here are');
}

/** Waits for it: a video still gets finer for some pictures after the one that showed the last change. */
async function skyBecomes(viewer, name, isSo) {
  for (let tries = 0; ; ++tries) {
    const [sky] = await bareColours(viewer, [{ x: 740, y: 20 }], `image-mode-${name}`);
    if (isSo(sky)) return;
    check(tries < 100, `the ${name} sky is ${sky}`);
  }
}

async function changesLook(viewer) {
  for (const [key, name] of [
    ['w', 'wireframe'],
    ['x', 'strains'],
  ]) {
    await changes(viewer, () => viewer.page.keyboard.press(key));
    await viewer.page.screenshot({ path: `${root}/build/e2e/image-mode-${name}.png` });
  }
  // With the server's scale.
  await viewer.page.locator('#strain-ticks li:last-child', { hasText: /^([125]0*|0\.0*[125]) %$/ }).waitFor();
  // The sky is the page's: as the system is, light, dark.
  for (const key of ['h', 'h']) await viewer.page.keyboard.press(key);
  await skyBecomes(viewer, 'dark', (sky) => Math.max(...sky) < 80);
  await viewer.page.keyboard.press('h');
  await skyBecomes(viewer, 'light', (sky) => Math.min(...sky) > 180);
  for (const key of ['w', 'x']) await changes(viewer, () => viewer.page.keyboard.press(key));
}

async function savesPicture(viewer) {
  const at = await viewer.at(0.475, 0.175);
  const isCloth = ([colour]) => Math.max(...colour) - Math.min(...colour) > 20;  // strains at rest are grey
  await coloursOnce(viewer, [at], 'image-mode-cloth', isCloth, 'the cloth is');
  const { png } = await savedPng(viewer);
  await writeFile(`${root}/build/e2e/image-mode-saved.png`, png);
  const [[saved], [shown]] = [await viewer.coloursOf(png, [at]), await viewer.colours([at], 'image-mode-to-save')];
  check(distance(saved, shown) < 6, `the cloth is ${saved} in the file and ${shown} on the page`);
}

async function goesBack(viewer) {
  await viewer.page.keyboard.press('q');
  await viewer.until('k.picture === undefined');
  check(await viewer.page.isHidden('#picture'), 'the picture is still there');
  const drawn = await viewer.read('k.framesDrawn');
  await viewer.page.keyboard.press('ArrowLeft');
  await viewer.until('k.framesDrawn > given.drawn', { drawn });
  await isInPlace(viewer, 'image-mode-left');
  check(viewer.errors.length === 0, `console: ${viewer.errors.join('; ')}`);
}

/** On a sheet that nothing else moves. */
async function takesTools(viewer, url) {
  await enter(viewer);
  await viewer.choose('grab');
  const { state_hash: hash } = await post(url, 'SheetService/GetSheet', kSeen);
  const { z } = await viewer.read('k.toWorld(0.5, 0.2)');
  const from = await viewer.at(0.5, 0.2);
  await viewer.drag(from, { x: from.x, y: from.y - 60 });
  await viewer.until('k.toWorld(0.5, 0.2).z > given.z + 0.02', { z });
  await viewer.page.screenshot({ path: `${root}/build/e2e/image-mode-grab.png` });
  await viewer.page.mouse.up();
  await viewer.page.keyboard.press(' ');
  await viewer.until('k.isPaused');
  const pulled = await post(url, 'SheetService/GetSheet', kSeen);
  check(pulled.state_hash !== hash, 'the server has the sheet as it was before the pull');
  await viewer.choose('pin');
  // A tapped place is found on the mesh, which comes seldom: it is to lie where the picture has it.
  await viewer.until('k.tick === given.tick', { tick: Number(pulled.tick) });
  // A flat place far from the cuts: where the sheet is crumpled a sight line may pass between its folds.
  // The mesh moves smoothly from frame to frame, and rests after the last one.
  for (let before; ; ) {
    await viewer.allDrawn();
    const at = await viewer.at(0.8, 0.8);
    if (before && Math.hypot(at.x - before.x, at.y - before.y) === 0) break;
    before = at;
  }
  await viewer.tap(0.8, 0.8);
  await viewer.until('k.pinnedVertices.length === 1');
  const { pinned_vertices: pinned } = await post(url, 'SheetService/GetSheet', kSeen);
  check(pinned.length === 1, `the server has ${pinned.length} pins`);
}

async function hidden(browser, server) {
  const proxy = await startSlowProxy(server.url, { delayMs: 0, bytesPerS: 1e9 });
  const viewer = await ViewerPage.open(browser, `${proxy.url}/?sheet=demo`, kSmall);
  await viewer.untilDrawn('k.connection === "live" && k.framesDrawn > 5');
  await enter(viewer);
  await viewer.setHidden(true);
  const serverTick = async () => Number((await post(server.url, 'SheetService/GetSheet', { name: 'sheets/demo' })).tick);
  // The pause reaches the server, and what was on its way arrives.
  const quiet = async () => {
    const { sent } = proxy.count('/images');
    const tick = await serverTick();
    while ((await serverTick()) < tick + 60);
    return proxy.count('/images').sent === sent;
  };
  let tries = 0;
  while (!(await quiet())) check(++tries < 10, 'pictures go on coming to a page that nobody sees');
  check((await viewer.read('k.picture.connection')) === 'live', 'the connection is gone');
  const { tick } = await viewer.read('k.picture');
  await viewer.setHidden(false);
  await viewer.until('k.picture.tick > given.tick + 60', { tick });
  await viewer.page.close();
  await proxy.stop();
}

async function withoutVideo(browser, server) {
  const viewer = await ViewerPage.open(browser, `${server.url}/?sheet=demo`, kSmall, (page) =>
    page.addInitScript(() => delete window.VideoDecoder),
  );
  await viewer.untilDrawn('k.connection === "live" && k.framesDrawn > 5');
  await enter(viewer);
  check((await viewer.read('k.picture.codec')) === 'IMAGE_JPEG', 'without VideoDecoder these are no JPEG pictures');
  const { tick } = await viewer.read('k.picture');
  await viewer.until('k.picture.tick > given.tick + 30', { tick });
  const [cloth, sky] = await viewer.colours([await viewer.at(0.5, 0.3), { x: 380, y: 4 }], 'image-mode-jpeg');
  check(distance(cloth, sky) > 25, `the cloth is ${cloth}, the sky ${sky}`);
  check(viewer.errors.length === 0, `console: ${viewer.errors.join('; ')}`);
  return viewer;
}

async function restarts(viewer, server) {
  const stop = async () => {
    await server.stop();
    await viewer.until('k.connection === "lost"');
  };
  await stop();
  await server.start();
  await viewer.until('k.connection === "live" && k.picture.connection === "live"');
  const { numShown } = await viewer.read('k.picture');
  await viewer.until('k.picture.numShown > given.numShown + 2', { numShown });
  await viewer.shows('#connection b', 'Live');
  await stop();
  await server.start(['--no-render']);
  await viewer.until('k.connection === "live" && k.picture === undefined');
  await viewer.notice(/No pictures, so the mesh is shown: this server draws no pictures \(none/);
  check((await viewer.page.getAttribute('#image-mode', 'aria-pressed')) === 'false', 'the button still looks pressed');
  await viewer.until('k.framesDrawn > given.drawn + 2', { drawn: await viewer.read('k.framesDrawn') });
  await viewer.shows('#connection b', 'Live');
  // Notices lie over the cloth.
  await viewer.page.evaluate(() => document.querySelectorAll('.notice').forEach((notice) => notice.click()));
  const [cloth, sky] = await viewer.colours([await viewer.at(0.5, 0.3), { x: 380, y: 4 }], 'image-mode-refused');
  check(distance(cloth, sky) > 25, `the cloth is ${cloth}, the sky ${sky}`);
  await stop();
  await server.start();
  await viewer.until('k.connection === "live"');
  await enter(viewer);
}

async function deletesLast(viewer) {
  const at = await viewer.at(0.5, 0.3);
  if (await viewer.page.isHidden('#panel-sheets')) await viewer.page.click('[data-panel=sheets]');
  await viewer.page.click('#sheet-list .icon');
  await viewer.page.click('#confirmation-yes');
  await viewer.shows('#status-tick', '–');
  check(await viewer.page.isHidden('#picture'), 'the picture is still there');
  const figures = await viewer.page.locator('#status dd').allTextContents();
  check(figures.slice(0, 5).every((text) => text === '–'), `there are still figures: ${figures}`);
  const [left, sky] = await bareColours(viewer, [at, { x: 4, y: at.y }], 'no-sheet');
  check(distance(left, sky) < 6, `where the sheet was the page is ${left}, beside it ${sky}`);
}

export function imageSteps(steps, browser, server) {
  let viewer;
  steps.step('pictures that the server draws take the place of the mesh, which then comes seldom', () =>
    takesThePlace(browser, server),
  );
  steps.step('they follow the camera: turned, nearer, moved, and from straight above', async () => {
    await post(server.url, 'SheetService/CreateSheet', { sheetId: 'seen', scene: kStill });
    viewer = await ViewerPage.open(browser, `${server.url}/?sheet=seen`, kWide);
    await viewer.untilDrawn('k.connection === "live" && k.framesDrawn > 0');
    await followsCamera(viewer);
  });
  steps.step('they have the size of the window', () => followsWindow(viewer));
  steps.step('they show cuts, made elsewhere and here', () => showsCuts(viewer, server.url));
  steps.step('they have wires and colours by strain', () => changesLook(viewer));
  steps.step('the picture that is seen is the one that is saved', () => savesPicture(viewer));
  steps.step('the mesh comes back', async () => {
    await goesBack(viewer);
  });
  steps.step('a vertex under the picture is pulled, and one is pinned', async () => {
    await takesTools(viewer, server.url);
    await viewer.page.close();
    await post(server.url, 'SheetService/DeleteSheet', kSeen);
  });
  steps.step('a page that nobody sees gets no pictures, and goes on when it is seen', () => hidden(browser, server));
  steps.step('where the browser has no WebCodecs they are JPEG', async () => {
    viewer = await withoutVideo(browser, server);
  });
  steps.step('they go on after a restart of the server, and where it has no renderer the mesh is shown', async () => {
    await restarts(viewer, server);
  });
  steps.step('of the last sheet that is deleted nothing stays, in a picture or as a mesh', async () => {
    await deletesLast(viewer);
    await post(server.url, 'SheetService/CreateSheet', { sheetId: 'after', scene: kStill });
    await viewer.page.click('#sheet-list .open');
    await viewer.until('k.sheet === "sheets/after" && k.picture?.connection === "live"');
    await viewer.page.keyboard.press('q');
    await viewer.until('k.picture === undefined && k.framesDrawn > 0');
    await deletesLast(viewer);
    await viewer.page.close();
  });
}
