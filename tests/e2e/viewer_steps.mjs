// One live sheet in the viewer, from its first frame to a restart of its server: looked at, pulled, pinned, cut.
import { readFile } from 'node:fs/promises';
import { check, kPatienceMs, post, root } from './harness.mjs';
import { ViewerPage } from './viewer_page.mjs';

const kWide = { viewport: { width: 1280, height: 720 }, colorScheme: 'light' };
const kPhone = { viewport: { width: 390, height: 844 }, colorScheme: 'dark', hasTouch: true, isMobile: true };
const kDemo = { name: 'sheets/demo' };
const kDemoVertices = 2500;
// The sheet of demo.json before it falls: uncut, level, 0.8 m up.
const kStartState = `k.numVertices === ${kDemoVertices} && k.pieces === 1
  && Math.abs(k.toWorld(0.5, 0).z - 0.8) < 1e-3`;

export function viewerSteps(steps, browser, server) {
  const { url } = server;
  let viewer;

  steps.step('the page opens and the sheet is live', async () => {
    viewer = await ViewerPage.open(browser, url, kWide);
    await viewer.untilDrawn('k.connection === "live" && k.framesDrawn > 0');
    const tick = await viewer.read('k.tick');
    await viewer.until('k.tick > given.tick + 10', { tick });
    check((await viewer.page.inputValue('#sheet-picker')) === 'sheets/demo', 'the demo sheet is not the one chosen');
  });

  steps.step('the scheduled cut arrives', async () => {
    await post(url, 'SheetService/SetSheetSpeed', { ...kDemo, speed: 4 });
    await viewer.until(`k.numVertices > ${kDemoVertices} && k.tick > 420`);
    await post(url, 'SheetService/SetSheetSpeed', { ...kDemo, speed: 1 });
    await viewer.screenshot('live');
  });

  steps.step('a curve is drawn on the live sheet, adjusted and given up', async () => {
    await viewer.choose('cut');
    for (const [x, y] of [
      [0.12, 0.5],
      [0.35, 0.8],
      [0.6, 0.25],
      [0.86, 0.62],
    ])
      await viewer.tap(x, y);
    const handle = viewer.page.locator('.handle', { hasText: '3' });
    const middle = async () => {
      const box = await handle.boundingBox();
      return { x: box.x + box.width / 2, y: box.y + box.height / 2 };
    };
    const from = await middle();
    const to = { x: from.x + 30, y: from.y - 20 };
    await viewer.drag(from, to);
    await viewer.page.mouse.up();
    await viewer.until('k.framesDrawn > given.drawn', { drawn: await viewer.read('k.framesDrawn') });
    const at = await middle();
    // The sheet keeps moving, and the point with it.
    check(Math.hypot(at.x - to.x, at.y - to.y) < 15, `point 3 is at ${JSON.stringify(at)}, not ${JSON.stringify(to)}`);
    await viewer.screenshot('curve');
    await viewer.page.keyboard.press('Escape');
    await viewer.page.waitForFunction(() => !document.querySelector('.handle:not([hidden])'));
    check((await viewer.read('k.pieces')) === 1, 'a curve that was given up has cut the sheet');
  });

  steps.step('pause stops the tick, step makes one, resume goes on', async () => {
    await viewer.page.click('#pause');
    await viewer.until('k.isPaused');
    const tick = await viewer.read('k.tick');
    await viewer.page.click('#step');
    await viewer.until('k.tick === given.tick + 1', { tick });
    check(await viewer.read('k.isPaused'), 'the sheet runs after a step');
    await viewer.page.click('#pause');
    await viewer.until('!k.isPaused && k.tick > given.tick + 1', { tick });
  });

  steps.step('two quick presses pause and go on, whatever has been answered in between', async () => {
    const resumed = viewer.page.waitForResponse(/SheetService\/ResumeSheet$/);
    await viewer.page.keyboard.press(' ');
    await viewer.page.keyboard.press(' ');
    check((await resumed).ok(), 'the sheet was not resumed');
    const tick = await viewer.read('k.tick');
    await viewer.until('!k.isPaused && k.tick > given.tick + 5', { tick });
  });

  steps.step('reset goes back to the uncut sheet', async () => {
    await viewer.page.keyboard.press(' ');
    await viewer.until('k.isPaused');
    await viewer.page.click('#reset');
    await viewer.until(kStartState);
  });

  steps.step('four taps and Enter cut the paused sheet in two', async () => {
    await viewer.choose('cut');
    for (const [x, y] of [
      [-0.05, 0.75],
      [0.3, 0.55],
      [0.7, 0.98],
      [1.05, 0.7],
    ])
      await viewer.tap(x, y);
    await viewer.page.waitForFunction(() => document.querySelectorAll('.handle:not([hidden])').length === 4);
    await viewer.screenshot('cut-preview');
    const before = await viewer.read('({ pieces: k.pieces, vertices: k.numVertices, tick: k.tick })');
    await viewer.page.keyboard.press('Enter');
    await viewer.until('k.pieces > given.pieces && k.numVertices > given.vertices', before);
    const notice = viewer.page.locator('.notice', { hasText: /^Cut: 2 pieces/ });
    await notice.waitFor();
    check(await notice.locator('details p').first().isHidden(), 'the details are open before anybody asks');
    await notice.locator('summary').click();
    await notice.locator('p', { hasText: /^The cut is at most [\d.]+ mm off the line\.$/ }).waitFor();
    await notice.locator('p', { hasText: /^\d+ new vertices, at tick \d+\.$/ }).waitFor();
    await viewer.screenshot('cut-details');
    await notice.click({ position: { x: 5, y: 5 } });
    await notice.waitFor({ state: 'detached' });
    const { cuts } = await post(url, 'CutService/ListCuts', { parent: kDemo.name });
    check(cuts.length === 1 && cuts[0].result.pieces === 2, `the server's journal: ${JSON.stringify(cuts)}`);
    check(cuts[0].cut.view?.layers === 'NEAREST', 'what is seen is not what was cut');
  });

  steps.step('the sheet falls when it runs on', async () => {
    await viewer.choose('view');
    await viewer.page.keyboard.press(' ');
    const { tick } = await viewer.read('({ tick: k.tick })');
    await viewer.until('!k.isPaused && k.tick > given.tick + 40 && k.toWorld(0.5, 0).z < 0.7', { tick });
    await viewer.screenshot('cut');
  });

  steps.step('a dragged vertex takes the sheet along', async () => {
    await viewer.page.keyboard.press('r');
    await viewer.until(`k.numVertices === ${kDemoVertices} && k.pieces === 1`);
    const tick = await viewer.read('k.tick');
    await viewer.until('k.tick > given.tick + 60', { tick });
    await viewer.choose('grab');
    await viewer.page.keyboard.press(' ');
    await viewer.until('k.isPaused');
    const material = { x: 0.5, y: 0.5 };
    const from = await viewer.at(material.x, material.y);
    const { z } = await viewer.read('k.toWorld(0.5, 0.5)');
    await viewer.drag(from, { x: from.x, y: from.y - 190 });
    // The spring ends at the pointer, well above the sheet, which follows as soon as it runs.
    const row = Array.from({ length: 41 }, (_, i) => ({ x: from.x - 20 + i, y: from.y - 170 }));
    const isSpring = ([red, , blue]) => red > 180 && red - blue > 120;
    check((await viewer.colours(row, 'grab')).some(isSpring), 'no spring is seen below the pointer');
    await viewer.page.keyboard.press(' ');
    await viewer.until('k.toWorld(given.x, given.y).z > given.z + 0.12', { ...material, z });
    await viewer.page.mouse.up();
    await viewer.until('k.toWorld(given.x, given.y).z < given.z + 0.1', { ...material, z });
    check(!(await viewer.colours(row, 'let-go')).some(isSpring), 'the spring is still seen');
  });

  steps.step('a tap pins a vertex, another lets it go', async () => {
    await viewer.page.keyboard.press(' ');
    await viewer.until('k.isPaused');
    await viewer.page.click('#reset');
    await viewer.until(kStartState);
    await viewer.choose('pin');
    check((await viewer.read('k.pinnedVertices.length')) === 2, 'the demo scene has other pins than its two corners');
    // Row 20, column 25 of the 50 x 50 grid.
    const [vertex, x, y] = [20 * 50 + 25, 25 / 49, 20 / 49];
    await viewer.tap(x, y);
    await viewer.until('k.pinnedVertices.length === 3 && k.pinnedVertices.includes(given.vertex)', { vertex });
    await viewer.tap(x, y);
    await viewer.until('k.pinnedVertices.length === 2');
    await viewer.page.keyboard.press(' ');
    const tick = await viewer.read('k.tick');
    await viewer.until('!k.isPaused && k.tick > given.tick + 90', { tick });
  });

  steps.step('strains colour the sheet, and are streamed only as long as they are shown', async () => {
    check((await viewer.read('k.numStrains')) === 0, 'strains that nobody asked for');
    const before = await viewer.read('({ drawn: k.framesDrawn, vertices: k.numVertices })');
    await viewer.page.click('#by-strain');
    await viewer.until('k.numStrains === given.vertices && k.framesDrawn > given.drawn + 1', before);
    // The page has the strains before it draws them.
    await viewer.page.locator('#strain-ticks li:last-child', { hasText: /^[\d.]+ %$/ }).waitFor();
    await viewer.screenshot('strain');
    await viewer.page.keyboard.press('x');
    await viewer.until('k.numStrains === 0');
    check(await viewer.page.isHidden('#strain-legend'), 'the scale is still there');
  });

  steps.step('the wireframe comes and goes', async () => {
    await viewer.page.keyboard.press('w');
    await viewer.until('k.isWireframe');
    await viewer.screenshot('wireframe');
    await viewer.page.click('#wireframe');
    await viewer.until('!k.isWireframe');
    await viewer.page.mouse.move(640, 5);  // off the button, which would look hovered over in every picture from here on
  });

  steps.step('the gravity slider reaches the server', async () => {
    await viewer.page.click('[data-panel=physics]');
    await viewer.page.fill('#gravity', '1.62');
    await viewer.shows('#gravity-value', '1.62 m/s²');
    const deadline = Date.now() + kPatienceMs;
    let z;
    do {
      z = (await post(url, 'SheetService/GetSheet', kDemo)).scene.gravity_mps2?.z;
    } while (z !== -1.62 && Date.now() < deadline);
    check(z === -1.62, `the server's gravity is ${z}`);
    await viewer.page.click('#panel-physics [data-close]');
  });

  steps.step('a pause right after another change is shown, though the sheet then stands still', async () => {
    for (const z of [-3, -4, -5]) {
      await post(url, 'InteractionService/SetSheetGravity', { ...kDemo, setGravity: { gravityMps2: { z } } });
      // The page has asked for the settings just now, and may not at once again.
      await viewer.shows('#gravity-value', `${-z}.00 m/s²`);
      await post(url, 'SheetService/PauseSheet', kDemo);
      await viewer.shows('#pause span', 'Resume');
      await post(url, 'SheetService/ResumeSheet', kDemo);
      await viewer.shows('#pause span', 'Pause');
    }
  });

  steps.step('a failed call for the settings is made again, though the sheet stands still', async () => {
    let refusals = 2;
    const getSheet = '**/kerf.v1.SheetService/GetSheet';
    await viewer.route(getSheet, (route) =>
      refusals-- > 0 ? route.fulfill({ status: 503, body: '{}' }) : route.continue(),
    );
    await post(url, 'SheetService/PauseSheet', kDemo);
    await viewer.shows('#pause span', 'Resume');
    check(refusals < 0, 'no call was refused');
    await viewer.page.unroute(getSheet);
    await post(url, 'SheetService/ResumeSheet', kDemo);
    await viewer.shows('#pause span', 'Pause');
    // The browser itself writes the refusals to the console.
    viewer.errors = viewer.errors.filter((error) => !error.includes('503'));
  });

  steps.step('another sheet is chosen, and the first again', async () => {
    const { sheet_id, commands, ...scene } = JSON.parse(await readFile(`${root}/tests/e2e/demo.json`, 'utf8'));
    const grid = { columns: 8, rows: 8, width_m: 0.5, height_m: 0.5 };
    await post(url, 'SheetService/CreateSheet', { sheetId: 'second', scene: { ...scene, grid } });
    for (let round = 0; round < 3; ++round) {
      await viewer.pick('second');
      const isSecond = 'k.sheet === "sheets/second" && k.connection === "live" && k.numVertices === 64';
      await viewer.until(`${isSecond} && k.tick > 0`);
      if (round === 0) await viewer.screenshot('second');
      await viewer.pick('demo');
      await viewer.until(`k.sheet === "sheets/demo" && k.connection === "live" && k.numVertices >= ${kDemoVertices}`);
      const tick = await viewer.read('k.tick');
      await viewer.until('k.tick > given.tick', { tick });
    }
    await post(url, 'SheetService/DeleteSheet', { name: 'sheets/second' });
  });

  steps.step('the help opens with ? and the page logged no error', async () => {
    await viewer.page.keyboard.press('?');
    await viewer.page.locator('#help[open]').waitFor();
    await viewer.screenshot('help');
    await viewer.page.keyboard.press('Escape');
    check(viewer.errors.length === 0, `console: ${viewer.errors.join('; ')}`);
  });

  steps.step('a freehand line is cut on a phone, in the dark', async () => {
    await post(url, 'SheetService/PauseSheet', kDemo);
    await post(url, 'SheetService/ResetSheet', kDemo);
    await post(url, 'InteractionService/SetSheetGravity', { ...kDemo, setGravity: { gravityMps2: { z: -9.81 } } });
    // Paused, it holds still under the finger.
    const phone = await ViewerPage.open(browser, `${url}/?sheet=demo`, kPhone);
    // The view fits the colliders, too, once they are known.
    const isKnown = `k.numVertices === ${kDemoVertices} && k.pinnedVertices.length === 2`;
    await phone.untilDrawn(`k.connection === "live" && k.framesDrawn > 0 && ${isKnown}`);
    await phone.choose('cut');
    await phone.page.click('#cut-panel [data-mode=lines]');
    for (const [x, y] of [[0.2, 0.4], [0.7, 0.5]]) {
      const at = await phone.at(x, y);
      await phone.page.touchscreen.tap(at.x, at.y);
    }
    await phone.allDrawn();
    await phone.touchDrag(await phone.at(0.2, 0.4), await phone.at(0.3, 0.8));
    await phone.allDrawn();
    const moved = await phone.page.locator('.handle').first().boundingBox();
    const wanted = await phone.at(0.3, 0.8);
    const off = Math.hypot(moved.x + 0.5 * moved.width - wanted.x, moved.y + 0.5 * moved.height - wanted.y);
    check(off < 2, `a point dragged by a finger is ${off} px from where that left it`);
    await phone.screenshot('phone-touch');
    await phone.page.click('#cut-cancel');
    await phone.page.click('#cut-panel [data-mode=freehand]');
    await phone.drag(await phone.at(-0.04, 0.7), await phone.at(0.5, 0.75));
    const end = await phone.at(1.04, 0.7);
    await phone.page.mouse.move(end.x, end.y, { steps: 8 });
    await phone.page.mouse.up();
    await phone.screenshot('phone-cut');
    await phone.page.click('#cut-apply');
    await phone.until('k.pieces === 2');
    await phone.choose('view');
    await phone.page.click('#pause');
    const tick = await phone.read('k.tick');
    await phone.until('!k.isPaused && k.tick > given.tick + 60', { tick });
    await phone.screenshot('phone');
    const overflow = await phone.page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
    check(overflow <= 0, `the page is ${overflow} px too wide for a phone`);
    check(phone.errors.length === 0, `console: ${phone.errors.join('; ')}`);
    await phone.page.close();
  });

  steps.step('the ball does not show through the cloth on it', async () => {
    await post(url, 'SheetService/PauseSheet', kDemo);
    const scene = JSON.parse(await readFile(`${root}/tests/e2e/demo.json`, 'utf8'));
    const { center, radius_m: radius } = scene.colliders[0].sphere;
    const open = async (prepare) => {
      const page = await ViewerPage.open(browser, `${url}/?sheet=demo`, kPhone, prepare);
      await page.untilDrawn('k.connection === "live" && k.isPaused && k.framesDrawn > 0 && k.pinnedVertices.length === 2');
      await page.until('k.framesDrawn > given.drawn', { drawn: await page.read('k.framesDrawn - 1') });
      return page;
    };
    // The same picture with a needle for a ball, which it takes as much room as, inside the cloth.
    const needle = { box: { center, halfExtentsM: { x: radius, y: 1e-4, z: 1e-4 } } };
    const pages = [
      await open(),
      await open((page) =>
        page.route('**/kerf.v1.SheetService/GetSheet', async (route) => {
          const response = await route.fetch();
          const sheet = await response.json();
          sheet.scene.colliders[0] = needle;
          await route.fulfill({ response, json: sheet });
        }),
      ),
    ];
    // Points of the cloth that lie on the ball, where it is seen from outside.
    const points = await pages[0].page.evaluate(
      ([middle, reach]) => {
        const found = [];
        for (let i = 1; i < 160; ++i) {
          for (let j = 1; j < 160; ++j) {
            const at = window.kerf.toWorld(i / 160, j / 160);
            const [x, y, z] = [at.x - middle.x, at.y - middle.y, at.z - middle.z];
            const distance = Math.hypot(x, y, z);
            // The first view is from (0.5, -1, 0.62).
            const facing = (0.5 * x - y + 0.62 * z) / (distance * Math.hypot(0.5, 1, 0.62));
            if (distance < 1.03 * reach && facing > 0.1) found.push(window.kerf.toClient(i / 160, j / 160));
          }
        }
        return found;
      },
      [center, radius],
    );
    check(points.length > 500, `only ${points.length} points of the cloth lie on the ball`);
    const [withBall, without] = [
      await pages[0].colours(points, 'ball'),
      await pages[1].colours(points, 'no-ball'),
    ];
    const differs = (colour, other) => colour.some((value, k) => Math.abs(value - other[k]) > 24);
    const wrong = withBall.filter((colour, i) => differs(colour, without[i])).length;
    console.log(`         the ball changes ${wrong} of ${points.length} points of the cloth`);
    check(wrong <= 0.01 * points.length, `the ball shows through at ${wrong} of ${points.length} points`);
    for (const { page } of pages) await page.close();
  });

  steps.step('a sheet that is not there is told in words', async () => {
    const lost = await ViewerPage.open(browser, `${url}/?sheet=nowhere`, kWide);
    await lost.page.locator('#connection-detail', { hasText: 'nowhere' }).waitFor();
    await lost.page.close();
  });

  steps.step('the viewer survives a restart of the server without a reload', async () => {
    await server.stop();
    await viewer.until('k.connection === "lost"');
    await viewer.screenshot('lost');
    await server.start();
    await viewer.until('k.connection === "live" && k.pieces === 1');
  });
}
