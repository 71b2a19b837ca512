// The viewer in Chromium against a real kerfd. Waits are for conditions, never for time; nothing about speed is
// asserted.
import { readFile } from 'node:fs/promises';
import { Steps, check, kPatienceMs, launchChromium, post, root, startKerfd } from './harness.mjs';
import { ViewerPage } from './viewer_page.mjs';

const [kerfdPath, web, chromiumPath] = process.argv.slice(2);
const kWide = { viewport: { width: 1280, height: 720 }, colorScheme: 'light' };
const kTall = { viewport: { width: 1280, height: 960 }, colorScheme: 'light' };
const kPhone = { viewport: { width: 390, height: 844 }, colorScheme: 'dark', hasTouch: true, isMobile: true };
const kDemo = { name: 'sheets/demo' };
const kDemoVertices = 2500;
// The sheet of deploy/scenes/demo.json before it falls: uncut, level, 0.8 m up.
const kStartState = `k.numVertices === ${kDemoVertices} && k.pieces === 1
  && Math.abs(k.toWorld(0.5, 0).z - 0.8) < 1e-3`;

let kerfd = await startKerfd(kerfdPath, web);
const browser = await launchChromium(chromiumPath);
let viewer;
const steps = new Steps(
  async (name) => {
    await viewer?.screenshot(`failed-${name.replaceAll(/\W+/g, '-')}`).catch((error) => console.log(String(error)));
  },
  () => check(ViewerPage.exceptions.length === 0, `uncaught on a page: ${ViewerPage.exceptions.join('; ')}`),
);

await steps.step('the page opens and the sheet is live', async () => {
  viewer = await ViewerPage.open(browser, kerfd.url, kWide);
  await viewer.until('k.connection === "live" && k.framesDrawn > 0');
  const tick = await viewer.read('k.tick');
  await viewer.until('k.tick > given.tick + 10', { tick });
  check((await viewer.page.inputValue('#sheet-picker')) === 'sheets/demo', 'the demo sheet is not the one chosen');
});

await steps.step('the scheduled cut arrives', async () => {
  await viewer.until(`k.numVertices > ${kDemoVertices} && k.tick > 420`);
  await viewer.screenshot('live');
});

await steps.step('a curve is drawn on the live sheet, adjusted and given up', async () => {
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
  // The sheet goes on moving, and the point with it.
  check(Math.hypot(at.x - to.x, at.y - to.y) < 15, `point 3 is at ${JSON.stringify(at)}, not ${JSON.stringify(to)}`);
  await viewer.screenshot('curve');
  await viewer.page.keyboard.press('Escape');
  await viewer.page.waitForFunction(() => !document.querySelector('.handle:not([hidden])'));
  check((await viewer.read('k.pieces')) === 1, 'a curve that was given up has cut the sheet');
});

await steps.step('pause stops the tick, step makes one, resume goes on', async () => {
  await viewer.page.click('#pause');
  await viewer.until('k.isPaused');
  const tick = await viewer.read('k.tick');
  await viewer.page.click('#step');
  await viewer.until('k.tick === given.tick + 1', { tick });
  check(await viewer.read('k.isPaused'), 'the sheet runs after a step');
  await viewer.page.click('#pause');
  await viewer.until('!k.isPaused && k.tick > given.tick + 1', { tick });
});

await steps.step('reset goes back to the uncut sheet', async () => {
  await viewer.page.keyboard.press(' ');
  await viewer.until('k.isPaused');
  await viewer.page.click('#reset');
  await viewer.until(kStartState);
});

await steps.step('four taps and Enter cut the paused sheet in two', async () => {
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
  await viewer.notice(/Cut at tick \d+: 2 pieces, \d+ new vertices, deviation/);
  const { cuts } = await post(kerfd.url, 'CutService/ListCuts', { parent: kDemo.name });
  check(cuts.length === 1 && cuts[0].result.pieces === 2, `the server's journal: ${JSON.stringify(cuts)}`);
  check(cuts[0].cut.view?.layers === 'NEAREST', 'what is seen is not what was cut');
});

await steps.step('the sheet falls when it runs on', async () => {
  await viewer.choose('view');
  await viewer.page.keyboard.press(' ');
  const { tick } = await viewer.read('({ tick: k.tick })');
  await viewer.until('!k.isPaused && k.tick > given.tick + 40 && k.toWorld(0.5, 0).z < 0.7', { tick });
  await viewer.screenshot('cut');
});

await steps.step('a dragged vertex takes the sheet along', async () => {
  await viewer.page.keyboard.press('r');
  await viewer.until(`k.numVertices === ${kDemoVertices} && k.pieces === 1`);
  const tick = await viewer.read('k.tick');
  await viewer.until('k.tick > given.tick + 60', { tick });
  await viewer.choose('grab');
  const material = { x: 0.5, y: 0.5 };
  const from = await viewer.at(material.x, material.y);
  const { z } = await viewer.read('k.toWorld(0.5, 0.5)');
  await viewer.drag(from, { x: from.x, y: from.y - 190 });
  await viewer.until('k.toWorld(given.x, given.y).z > given.z + 0.12', { ...material, z });
  await viewer.screenshot('grab');
  await viewer.page.mouse.up();
  await viewer.until('k.toWorld(given.x, given.y).z < given.z + 0.1', { ...material, z });
});

await steps.step('a tap pins a vertex, another lets it go', async () => {
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

await steps.step('the wireframe comes and goes', async () => {
  await viewer.page.keyboard.press('w');
  await viewer.until('k.isWireframe');
  await viewer.screenshot('wireframe');
  await viewer.page.click('#wireframe');
  await viewer.until('!k.isWireframe');
  await viewer.page.mouse.move(640, 5);  // off the button, which would look hovered over in every picture from here on
});

await steps.step('the gravity slider reaches the server', async () => {
  await viewer.page.fill('#gravity', '1.62');
  await viewer.shows('#gravity-value', '1.62 m/s²');
  const deadline = Date.now() + kPatienceMs;
  let z;
  do {
    z = (await post(kerfd.url, 'SheetService/GetSheet', kDemo)).scene.gravity_mps2?.z;
  } while (z !== -1.62 && Date.now() < deadline);
  check(z === -1.62, `the server's gravity is ${z}`);
});

await steps.step('a pause right after another change is shown, though the sheet then stands still', async () => {
  for (const z of [-3, -4, -5]) {
    await post(kerfd.url, 'InteractionService/SetSheetGravity', { ...kDemo, setGravity: { gravityMps2: { z } } });
    // The page has asked for the settings just now, and may not at once again.
    await viewer.shows('#gravity-value', `${-z}.00 m/s²`);
    await post(kerfd.url, 'SheetService/PauseSheet', kDemo);
    await viewer.shows('#pause span', 'Resume');
    await post(kerfd.url, 'SheetService/ResumeSheet', kDemo);
    await viewer.shows('#pause span', 'Pause');
  }
});

await steps.step('a failed call for the settings is made again, though the sheet stands still', async () => {
  let refusals = 2;
  const getSheet = '**/kerf.v1.SheetService/GetSheet';
  await viewer.page.route(getSheet, (route) =>
    refusals-- > 0 ? route.fulfill({ status: 503, body: '{}' }) : route.continue(),
  );
  await post(kerfd.url, 'SheetService/PauseSheet', kDemo);
  await viewer.shows('#pause span', 'Resume');
  check(refusals < 0, 'no call was refused');
  await viewer.page.unroute(getSheet);
  await post(kerfd.url, 'SheetService/ResumeSheet', kDemo);
  await viewer.shows('#pause span', 'Pause');
  // The browser itself writes the refusals to the console.
  viewer.errors = viewer.errors.filter((error) => !error.includes('503'));
});

await steps.step('another sheet is chosen, and the first again', async () => {
  const { sheet_id, commands, ...scene } = JSON.parse(await readFile(`${root}/deploy/scenes/demo.json`, 'utf8'));
  const grid = { columns: 8, rows: 8, width_m: 0.5, height_m: 0.5 };
  await post(kerfd.url, 'SheetService/CreateSheet', { sheetId: 'second', scene: { ...scene, grid } });
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
  await post(kerfd.url, 'SheetService/DeleteSheet', { name: 'sheets/second' });
});

await steps.step('the help opens with ? and the page logged no error', async () => {
  await viewer.page.keyboard.press('?');
  await viewer.page.locator('#help[open]').waitFor();
  await viewer.screenshot('help');
  await viewer.page.keyboard.press('Escape');
  check(viewer.errors.length === 0, `console: ${viewer.errors.join('; ')}`);
});

// A sheet folded in the middle, one half behind the other, that nothing moves.
function foldedScene() {
  const side = 31;
  const numbers = Array.from({ length: side * side }, (_, i) => [(i % side) / (side - 1), Math.floor(i / side) / (side - 1)]);
  const vertices = numbers.map(([u, v]) => `v ${u} ${0.4 * (v - 0.5)} ${Math.sqrt(0.84) * Math.abs(v - 0.5)}`);
  const faces = numbers.flatMap(([u, v], i) => {
    const corners = [i + 1, i + 2, i + 2 + side, i + 1 + side].map((vertex) => `${vertex}/${vertex}`);
    return u < 1 && v < 1 ? [`f ${corners.slice(0, 3).join(' ')}`, `f ${corners[0]} ${corners[2]} ${corners[3]}`] : [];
  });
  const text = [...vertices, ...numbers.map(([u, v]) => `vt ${u} ${v}`), ...faces].join('\n');
  return { obj: { text }, gravityMps2: {}, material: { preset: 'paper' } };
}

const lastCut = async (sheet) => (await post(kerfd.url, 'CutService/ListCuts', { parent: sheet })).cuts?.at(-1);
const kFold = 'sheets/fold';
let fold;

await steps.step('what is seen is cut, or every layer, or the material', async () => {
  await post(kerfd.url, 'SheetService/CreateSheet', { sheetId: 'fold', scene: foldedScene() });
  await post(kerfd.url, 'SheetService/PauseSheet', { name: kFold });
  fold = await ViewerPage.open(browser, `${kerfd.url}/?sheet=fold`, kTall);
  await fold.until('k.connection === "live" && k.isPaused && k.framesDrawn > 0');
  await fold.choose('cut');
  // On the half in front, where the other is behind it.
  const tapLine = async () => {
    await fold.page.keyboard.press('i');
    await fold.tap(0.3, 0.25);
    await fold.tap(0.5, 0.2);
    await fold.tap(0.7, 0.25);
  };
  for (const [key, layers, stretches] of [
    ['1', 'NEAREST', 1],
    ['2', 'ALL', 2],
    ['3', 'ONE_PIECE', 2],
    ['4', 'DEPTH_RANGE', 1],
  ]) {
    const { version } = await fold.read('({ version: k.topologyVersion })');
    await fold.page.keyboard.press(key);
    await tapLine();
    if (key === '4') await fold.screenshot('cut-depth');
    await fold.page.keyboard.press('Enter');
    await fold.until('k.topologyVersion > given.version', { version });
    const { cut, result } = await lastCut(kFold);
    check(cut.view?.layers === layers, `key ${key} cut ${JSON.stringify(cut.view?.layers)}`);
    check(result.layers.length === stretches, `${layers} cut ${result.layers.length} stretches, not ${stretches}`);
    if (key === '2') await fold.screenshot('cut-layers');
    await fold.page.keyboard.press('Control+z');
    await fold.until('k.topologyVersion > given.version', { version: version + 1 });
  }
  await fold.page.keyboard.press('5');
  await tapLine();
  await fold.page.keyboard.press('Enter');
  await fold.notice(/Cut at tick/);
  const { cut } = await lastCut(kFold);
  const [first] = cut.curve.polyline.points;
  check(!cut.view && Math.hypot(first.x - 0.3, first.y - 0.25) < 0.01, `on the material: ${JSON.stringify(cut)}`);
  await fold.page.keyboard.press('1');
  await fold.page.keyboard.press('Control+z');
  await fold.until('k.numVertices === 961');
});

await steps.step('a point of a curve gets a weight, and the curve is rational', async () => {
  await fold.page.keyboard.press('b');
  for (const [x, y] of [
    [0.15, 0.3],
    [0.5, 0.02],
    [0.85, 0.3],
  ])
    await fold.tap(x, y);
  await fold.page.locator('.handle', { hasText: '2' }).click();
  await fold.page.fill('#cut-weight-value', '1');
  await fold.shows('#cut-weight-shown', '10.00');
  await fold.page.focus('#canvas');
  await fold.page.keyboard.press('-');
  await fold.shows('#cut-weight-shown', '8.00');
  await fold.screenshot('cut-weight');
  await fold.page.keyboard.press('Enter');
  await fold.until('k.numVertices > 961');
  const { cut } = await lastCut(kFold);
  const { weights } = cut.curve.path.subpaths[0].segments[0].quadratic;
  check(Math.abs(weights[1] / weights[0] - 8) < 1e-9, `weights ${weights}`);
  await fold.page.keyboard.press('Control+z');
  await fold.until('k.numVertices === 961');
});

await steps.step('circle, ellipse and a dashed freehand loop are drawn by a drag', async () => {
  for (const [mode, shape, pieces] of [
    ['circle', 'circle', 2],
    ['ellipse', 'ellipse', 3],
  ]) {
    const x = mode === 'circle' ? 0.3 : 0.7;
    await fold.page.click(`#cut-panel [data-mode=${mode}]`);
    await fold.drag(await fold.at(x, 0.25), await fold.at(x + 0.07, 0.25));
    await fold.page.mouse.up();
    await fold.screenshot(`cut-${mode}`);
    await fold.page.click('#cut-apply');
    await fold.until('k.pieces === given.pieces', { pieces });
    const { cut } = await lastCut(kFold);
    check(cut.curve[shape] && cut.view, `cut ${JSON.stringify(cut)}`);
  }
  await fold.page.click('#cut-panel [data-mode=freehand]');
  await fold.page.check('#cut-dashed');
  await fold.page.fill('#cut-dash-cut', '30');
  await fold.page.fill('#cut-dash-left', '15');
  const around = (angle) => fold.at(0.5 + 0.08 * Math.cos(angle), 0.25 + 0.11 * Math.sin(angle));
  await fold.drag(await around(0), await around(0.3));
  for (let i = 2; i <= 20; ++i) {
    const { x, y } = await around(0.3 * i);
    await fold.page.mouse.move(x, y);
  }
  const end = await around(0.03);
  await fold.page.mouse.move(end.x, end.y);
  await fold.page.mouse.up();
  await fold.screenshot('cut-dashes');
  const { version } = await fold.read('({ version: k.topologyVersion })');
  await fold.page.click('#cut-apply');
  await fold.until('k.topologyVersion > given.version', { version });
  const { cut, result } = await lastCut(kFold);
  const points = cut.curve.polyline.points;
  check(points[0].x === points.at(-1).x && points[0].y === points.at(-1).y, 'the loop is not closed');
  check(cut.dash[0] === 0.03 && cut.dash[1] === 0.015 && result.pieces === 3, `perforated: ${JSON.stringify(result)}`);
  await fold.page.keyboard.press('d');
  check(!(await fold.page.isChecked('#cut-dashed')), 'D does not switch dashes off');
  await fold.page.mouse.move(640, 5);
  await fold.screenshot('cut-all');
  check(fold.errors.length === 0, `console: ${fold.errors.join('; ')}`);
  await fold.page.close();
});

// A frame, two holes by reference, a letter of two subpaths in a turned group, and what is no outline.
const kDrawing = `<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 200 100">
  <defs><circle id="hole" r="12"/></defs>
  <rect x="5" y="5" width="190" height="90" rx="12"/>
  <use href="#hole" x="40" y="50"/><use href="#hole" x="160" y="50"/>
  <g transform="translate(100 50) rotate(20)"><path d="M -25 30 L 0 -30 L 25 30 Z m 17 -8 h 16 l -8 -19 z"/></g>
  <text x="20" y="20">cut me not</text>
  <rect width="10" height="10" display="none"/>
</svg>`;
const kFlatScene = {
  grid: { columns: 41, rows: 41, widthM: 1, heightM: 1 },
  placement: { xAxis: { x: 1 }, yAxis: { y: Math.cos(0.7), z: Math.sin(0.7) } },
  gravityMps2: {},
};
let flat;

await steps.step('an SVG file is dropped on the sheet, moved, scaled and cut', async () => {
  await post(kerfd.url, 'SheetService/CreateSheet', { sheetId: 'flat', scene: kFlatScene, paused: true });
  flat = await ViewerPage.open(browser, `${kerfd.url}/?sheet=flat`, kTall);
  await flat.until('k.connection === "live" && k.isPaused && k.framesDrawn > 0');
  const transfer = await flat.page.evaluateHandle((text) => {
    const files = new DataTransfer();
    files.items.add(new File([text], 'sign.svg', { type: 'image/svg+xml' }));
    return files;
  }, kDrawing);
  await flat.page.dispatchEvent('#canvas', 'dragover', { dataTransfer: transfer });
  await flat.screenshot('svg-drop');
  await flat.page.dispatchEvent('#canvas', 'drop', { dataTransfer: transfer });
  await flat.until('k.tool === "cut"');
  await flat.page.locator('#cut-prompt', { hasText: 'sign.svg' }).waitFor();
  check(await flat.page.isDisabled('#cut-target'), 'a drawing on a picture is offered, and the server refuses it');
  await flat.screenshot('svg');
  // 0.9 m wide in the middle: smaller by its upper right corner, then dragged up from within.
  await flat.drag(await flat.at(0.95, 0.7), await flat.at(0.77, 0.61));
  await flat.page.mouse.up();
  await flat.drag(await flat.at(0.35, 0.4), await flat.at(0.45, 0.6));
  await flat.page.mouse.up();
  await flat.screenshot('svg-moved');
  await flat.page.keyboard.press('Enter');
  await flat.until('k.pieces === 6');
  await flat.notice(/Cut at tick \d+: 6 pieces/);
  await flat.notice(/text/);
  const { cut } = await lastCut('sheets/flat');
  const { min, max } = cut.fit;
  const wanted = [0.15, 0.487, 0.87, 0.828];
  const off = [min.x, min.y, max.x, max.y].map((value, i) => Math.abs(value - wanted[i]));
  check(Math.max(...off) < 0.01, `cut in ${JSON.stringify(cut.fit)}`);
  await flat.screenshot('svg-cut');
});

await steps.step('an SVG file is chosen, and what is none is refused in words', async () => {
  const choosing = flat.page.waitForEvent('filechooser');
  await flat.page.keyboard.press('Control+z');
  await flat.until('k.pieces === 1');
  await flat.page.setInputFiles('#svg-file', { name: 'notes.txt', mimeType: 'text/plain', buffer: Buffer.from('x') });
  await flat.notice(/notes.txt is no SVG drawing/);
  await flat.page.setInputFiles('#svg-file', {
    name: 'large.svg',
    mimeType: 'image/svg+xml',
    buffer: Buffer.alloc(512 * 1024 + 1, ' '),
  });
  await flat.notice(/large.svg has 513 KiB; the server takes drawings of at most 512/);
  await flat.page.keyboard.press('s');
  const chooser = await choosing;
  await chooser.setFiles({ name: 'broken.svg', mimeType: 'image/svg+xml', buffer: Buffer.from('<svg><path') });
  await flat.page.locator('#cut-prompt', { hasText: 'No outline of broken.svg' }).waitFor();
  await flat.page.click('#cut-apply');
  await flat.page.locator('.notice[data-kind=error]', { hasText: /^Nothing was cut: .*INVALID_ARGUMENT/ }).waitFor();
  await flat.screenshot('svg-broken');
  await flat.page.keyboard.press('Escape');
  // The browser writes the refusal to the console.
  flat.errors = flat.errors.filter((error) => !error.includes('400'));
  check(flat.errors.length === 0, `console: ${flat.errors.join('; ')}`);
});

await steps.step('pieces have colours that they keep while others are cut', async () => {
  const circle = async (x, y, radius) => {
    const { pieces } = await flat.read('({ pieces: k.pieces })');
    await flat.page.keyboard.press('o');
    await flat.drag(await flat.at(x, y), await flat.at(x + radius, y));
    await flat.page.mouse.up();
    await flat.page.keyboard.press('Enter');
    await flat.until('k.pieces > given.pieces', { pieces });
  };
  const colourAt = async (name, ...points) => {
    const px = [];
    for (const [x, y] of points) px.push(await flat.at(x, y));
    return flat.colours(px, name);
  };
  await circle(0.3, 0.7, 0.12);
  await flat.page.keyboard.press('k');
  await flat.until('k.isByPiece && k.pieceAt(0.3, 0.7) && k.pieceAt(0.5, 0.2)');
  const ids = await flat.read('[k.pieceAt(0.3, 0.7), k.pieceAt(0.5, 0.2)]');
  await flat.until('k.framesDrawn > given.drawn', { drawn: await flat.read('k.framesDrawn - 1') });
  const [disc, rest] = await colourAt('pieces', [0.3, 0.7], [0.5, 0.2]);
  check(disc.some((value, i) => Math.abs(value - rest[i]) > 40), `disc ${disc} and rest ${rest} look alike`);
  await circle(0.7, 0.6, 0.15);
  await flat.until('k.pieceAt(0.7, 0.6) && k.pieceAt(0.5, 0.2)');
  const after = await flat.read('[k.pieceAt(0.3, 0.7), k.pieceAt(0.5, 0.2), k.pieceAt(0.7, 0.6)]');
  check(after[0] === ids[0] && after[1] !== ids[1], `ids ${ids} became ${after}`);
  const { pieces } = await post(kerfd.url, 'CutService/ListPieces', { parent: 'sheets/flat' });
  check(pieces.map(({ id }) => Number(id)).sort().join() === [...after].sort().join(), `${JSON.stringify(pieces)}, ${after}`);
  await flat.page.mouse.move(640, 5);
  await flat.until('k.framesDrawn > given.drawn', { drawn: await flat.read('k.framesDrawn - 1') });
  const [kept] = await colourAt('pieces-cut-on', [0.3, 0.7]);
  check(kept.every((value, i) => Math.abs(value - disc[i]) < 8), `the disc was ${disc} and is ${kept}`);
  await flat.page.click('#by-piece');
  await flat.until('!k.isByPiece');
  check(flat.errors.length === 0, `console: ${flat.errors.join('; ')}`);
  await flat.page.close();
});

await steps.step('a freehand line is cut on a phone, in the dark', async () => {
  await post(kerfd.url, 'SheetService/PauseSheet', kDemo);
  await post(kerfd.url, 'SheetService/ResetSheet', kDemo);
  await post(kerfd.url, 'InteractionService/SetSheetGravity', { ...kDemo, setGravity: { gravityMps2: { z: -9.81 } } });
  // Paused, it holds still under the finger.
  const phone = await ViewerPage.open(browser, `${kerfd.url}/?sheet=demo`, kPhone);
  await phone.until(`k.connection === "live" && k.framesDrawn > 0 && k.numVertices === ${kDemoVertices}`);
  await phone.choose('cut');
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

await steps.step('the ball does not show through the cloth on it', async () => {
  await post(kerfd.url, 'SheetService/PauseSheet', kDemo);
  const scene = JSON.parse(await readFile(`${root}/deploy/scenes/demo.json`, 'utf8'));
  const { center, radius_m: radius } = scene.colliders[0].sphere;
  const open = async (prepare) => {
    const page = await ViewerPage.open(browser, `${kerfd.url}/?sheet=demo`, kPhone, prepare);
    await page.until('k.connection === "live" && k.isPaused && k.framesDrawn > 0 && k.pinnedVertices.length === 2');
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

await steps.step('a sheet that is not there is told in words', async () => {
  const lost = await ViewerPage.open(browser, `${kerfd.url}/?sheet=nowhere`, kWide);
  await lost.page.locator('#connection-detail', { hasText: 'nowhere' }).waitFor();
  await lost.page.close();
});

await steps.step('the viewer survives a restart of the server without a reload', async () => {
  const { host } = new URL(kerfd.url);
  check((await kerfd.stop()) === 0, 'kerfd did not end with status 0 on SIGTERM');
  await viewer.until('k.connection === "lost"');
  await viewer.screenshot('lost');
  kerfd = await startKerfd(kerfdPath, web, host);
  await viewer.until('k.connection === "live" && k.pieces === 1');
});

await browser.close();
const status = await kerfd.stop();
await steps.step('kerfd ends with status 0', async () => check(status === 0, `it ended with ${status}`));
console.log(`${steps.passed} passed, ${steps.failed} failed`);
process.exitCode = steps.failed === 0 ? 0 : 1;
