// What the cut tool does, on two sheets that nothing moves.
import { check, post } from './harness.mjs';
import { ViewerPage } from './viewer_page.mjs';

const kTall = { viewport: { width: 1280, height: 960 }, colorScheme: 'light' };

// A sheet folded in the middle, one half behind the other, that nothing moves.
function foldedScene() {
  const side = 31;
  const material = (i) => [i % side, Math.floor(i / side)].map((n) => n / (side - 1));
  const numbers = Array.from({ length: side * side }, (_, i) => material(i));
  const vertices = numbers.map(([u, v]) => `v ${u} ${0.4 * (v - 0.5)} ${Math.sqrt(0.84) * Math.abs(v - 0.5)}`);
  const faces = numbers.flatMap(([u, v], i) => {
    const corners = [i + 1, i + 2, i + 2 + side, i + 1 + side].map((vertex) => `${vertex}/${vertex}`);
    return u < 1 && v < 1 ? [`f ${corners.slice(0, 3).join(' ')}`, `f ${corners[0]} ${corners[2]} ${corners[3]}`] : [];
  });
  const text = [...vertices, ...numbers.map(([u, v]) => `vt ${u} ${v}`), ...faces].join('\n');
  return { obj: { text }, gravityMps2: {}, material: { preset: 'paper' } };
}

const kFold = 'sheets/fold';
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

/** Drawing on the picture and on the material, every kind of drawing, strips, and the colours of the pieces. */
export async function cuttingSteps(steps, browser, url) {
  const lastCut = async (sheet) => (await post(url, 'CutService/ListCuts', { parent: sheet })).cuts?.at(-1);
  let fold;
  let flat;

  await steps.step('what is seen is cut, or every layer, or the material', async () => {
    await post(url, 'SheetService/CreateSheet', { sheetId: 'fold', scene: foldedScene() });
    await post(url, 'SheetService/PauseSheet', { name: kFold });
    fold = await ViewerPage.open(browser, `${url}/?sheet=fold`, kTall);
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
    check(cut.dash[0] === 0.03 && cut.dash[1] === 0.015, `dashes ${cut.dash}`);
    check(result.pieces === 3, `a perforated loop falls out: ${result.pieces} pieces`);
    await fold.page.keyboard.press('d');
    check(!(await fold.page.isChecked('#cut-dashed')), 'D does not switch dashes off');
    await fold.page.mouse.move(640, 5);
    await fold.screenshot('cut-all');
    check(fold.errors.length === 0, `console: ${fold.errors.join('; ')}`);
    await fold.page.close();
  });

  await steps.step('an SVG file is dropped on the sheet, moved, scaled and cut', async () => {
    await post(url, 'SheetService/CreateSheet', { sheetId: 'flat', scene: kFlatScene, paused: true });
    flat = await ViewerPage.open(browser, `${url}/?sheet=flat`, kTall);
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
    const { pieces } = await post(url, 'CutService/ListPieces', { parent: 'sheets/flat' });
    const listed = pieces.map(({ id }) => Number(id));
    check(listed.sort().join() === [...after].sort().join(), `the server lists ${listed}, the page shows ${after}`);
    await flat.page.mouse.move(640, 5);
    await flat.until('k.framesDrawn > given.drawn', { drawn: await flat.read('k.framesDrawn - 1') });
    const [kept] = await colourAt('pieces-cut-on', [0.3, 0.7]);
    check(kept.every((value, i) => Math.abs(value - disc[i]) < 8), `the disc was ${disc} and is ${kept}`);
    await flat.page.click('#by-piece');
    await flat.until('!k.isByPiece');
    check(flat.errors.length === 0, `console: ${flat.errors.join('; ')}`);
    await flat.page.close();
  });

  await stripSteps(steps, browser, url, lastCut);
}

// Cuts with a width: what was pinned, held and coloured where the material goes, and what is there when it is back.
async function stripSteps(steps, browser, url, lastCut) {
  const kStrip = 'sheets/strip';
  const kMiddle = 840; // of 41 x 41 vertices
  let strip;
  const background = async (...points) => {
    const px = [];
    for (const [x, y] of points) px.push(await strip.at(x, y));
    return strip.colours(px, 'strip-colours');
  };
  const isRed = ([red, green, blue]) => red > green + 40 && red > blue + 40;

  await steps.step('a cut with a width shows its strip, takes it away and says how much', async () => {
    const scene = { ...kFlatScene, pins: [{ vertices: { vertices: [0, kMiddle] } }] };
    await post(url, 'SheetService/CreateSheet', { sheetId: 'strip', scene, paused: true });
    strip = await ViewerPage.open(browser, `${url}/?sheet=strip`, kTall);
    await strip.until('k.connection === "live" && k.isPaused && k.framesDrawn > 0 && k.pinnedVertices.length === 2');
    await strip.choose('cut');
    await strip.page.keyboard.press('5');
    await strip.page.keyboard.press('i');
    await strip.tap(0.2, 0.5);
    await strip.tap(0.8, 0.5);
    await strip.page.keyboard.press('t');
    await strip.page.keyboard.type('80');
    await strip.page.keyboard.press('Enter');
    check((await strip.page.inputValue('#cut-width')) === '80', 'the width is not typed after T');
    await strip.screenshot('strip');
    const [inside, end, beside, beyond] = await background([0.5, 0.535], [0.83, 0.5], [0.5, 0.545], [0.845, 0.5]);
    check(isRed(inside) && isRed(end), `the strip's preview is ${inside} inside and ${end} in its round end`);
    check(!isRed(beside) && !isRed(beyond), `the strip's preview is ${beside} beside and ${beyond} beyond it`);
    await strip.page.keyboard.press('Enter');
    await strip.notice(/^Cut at tick \d+: 1 piece, .* 530 cm² \([\d.]+ g\) taken away$/);
    const { cut, result } = await lastCut(kStrip);
    check(cut.width_m === 0.08 && !cut.view, `cut ${JSON.stringify(cut)}`);
    check(Math.abs(result.removed.area_m2 - (0.08 * 0.6 + Math.PI * 0.04 ** 2)) < 2e-4, `took ${result.removed.area_m2}`);
    await strip.until('k.pinnedVertices.length === 1');
    await strip.page.mouse.move(640, 5);
    await strip.screenshot('strip-cut');
  });

  await steps.step('vertices without material disturb neither grab, pieces, wireframe, fit nor undo', async () => {
    const { version } = await strip.read('({ version: k.topologyVersion })');
    await strip.choose('grab');
    await strip.drag(await strip.at(0.3, 0.75), await strip.at(0.4, 0.9));
    const hole = { curve: { circle: { center: { x: 0.3, y: 0.75 }, radiusM: 0.03 } }, widthM: 0.1 };
    await post(url, 'CutService/CreateCut', { parent: kStrip, cut: hole });
    await strip.until('k.topologyVersion > given.version', { version });
    await strip.screenshot('strip-held');
    await strip.page.mouse.up();
    const ring = { curve: { circle: { center: { x: 0.6, y: 0.25 }, radiusM: 0.15 } }, widthM: 0.05 };
    await post(url, 'CutService/CreateCut', { parent: kStrip, cut: ring });
    await strip.until('k.pieces === 2');
    await strip.page.keyboard.press('k');
    await strip.page.keyboard.press('w');
    await strip.page.keyboard.press('f');
    await strip.until('k.isByPiece && k.pieceAt(0.6, 0.25) && k.pieceAt(0.1, 0.1)');
    check((await strip.read('k.pieceAt(0.3, 0.75) ?? 0')) === 0, 'there is a piece in the hole');
    await strip.screenshot('strip-pieces');
    for (let cuts = 3; cuts > 0; --cuts) {
      const before = await strip.read('k.topologyVersion');
      await strip.page.keyboard.press('Control+z');
      await strip.until('k.topologyVersion > given.before', { before });
    }
    await strip.until('k.numVertices === 1681 && k.pieces === 1 && k.pieceAt(0.3, 0.75) && k.pieceAt(0.5, 0.5)');
    await strip.page.mouse.move(640, 5);
    const [middle, corner] = await background([0.51, 0.51], [0.11, 0.11]);
    check(middle.every((value, i) => Math.abs(value - corner[i]) < 60), `${middle} where the material is back, ${corner}`);
    await strip.screenshot('strip-undone');
    await strip.page.keyboard.press('w');
    await strip.page.keyboard.press('k');
  });

  await steps.step('one piece is chosen by a tap, and the last drawing is laid again', async () => {
    const ring = { curve: { circle: { center: { x: 0.6, y: 0.25 }, radiusM: 0.15 } }, widthM: 0.05 };
    await post(url, 'CutService/CreateCut', { parent: kStrip, cut: ring });
    await strip.until('k.pieces === 2');
    await strip.choose('cut');
    await strip.page.keyboard.press('3');
    await strip.page.fill('#cut-width', '0');
    await strip.shows('#cut-piece-shown', 'the one the line meets first');
    await strip.page.click('#cut-piece-choose');
    await strip.shows('#cut-prompt', 'Tap the piece that is to be cut');
    await strip.tap(0.6, 0.28);
    await strip.shows('#cut-piece-shown', 'the marked one');
    const line = async () => {
      await strip.page.keyboard.press('i');
      await strip.tap(0.2, 0.25);
      await strip.tap(0.95, 0.25);
    };
    await line();
    await strip.screenshot('piece-chosen');
    await strip.page.keyboard.press('Enter');
    await strip.until('k.pieces === 3');
    const { cut, result } = await lastCut(kStrip);
    check(cut.view.layers === 'ONE_PIECE' && cut.view.piece !== undefined, `cut ${JSON.stringify(cut.view)}`);
    check(result.layers.length === 1, `cut in ${result.layers.length} stretches, not through the disc alone`);
    await strip.page.keyboard.press('Control+z');
    await strip.until('k.pieces === 2');
    check((await strip.read('document.querySelectorAll(".handle:not([hidden])").length')) === 0, 'a drawing is left');
    await strip.page.keyboard.press('n');
    await strip.page.locator('.handle:not([hidden])').nth(1).waitFor();
    await strip.screenshot('again');
    await strip.page.click('#cut-piece-choose');
    await strip.shows('#cut-piece-shown', 'the one the line meets first');
    await strip.page.keyboard.press('Enter');
    await strip.until('k.pieces > 2 || document.querySelectorAll(".handle:not([hidden])").length === 0');
    const { cut: again, result: other } = await lastCut(kStrip);
    check(JSON.stringify(again.curve) === JSON.stringify(cut.curve), `again ${JSON.stringify(again.curve)}`);
    check(again.view.piece === undefined && other.layers.length === 2, `${other.layers.length} stretches beside the disc`);
    // The next is not sent before the one before is answered.
    const undo = async () => {
      const answer = strip.page.waitForResponse(/UndoCut/);
      await strip.page.keyboard.press('Control+z');
      await (await answer).finished();
    };
    await undo();
    await strip.until('k.pieces === 2');
    await undo();
    await strip.until('k.numVertices === 1681');
    await strip.page.keyboard.press('n');
    await strip.choose('grab');
    check((await strip.read('document.querySelectorAll(".handle:not([hidden])").length')) === 0, 'it stays on the canvas');
  });

  await steps.step('a dashed strip on the picture is cut, and one that takes all is refused in words', async () => {
    await strip.choose('cut');
    await strip.page.keyboard.press('1');
    await strip.page.keyboard.press('o');
    await strip.drag(await strip.at(0.5, 0.5), await strip.at(0.75, 0.5));
    await strip.page.mouse.up();
    await strip.page.fill('#cut-width', '5000');
    await strip.page.click('#cut-apply');
    await strip.notice(/^Nothing was cut: the strip would take the whole sheet away; .*FAILED_PRECONDITION/);
    await strip.page.fill('#cut-width', '25');
    await strip.page.check('#cut-dashed');
    await strip.page.fill('#cut-dash-cut', '60');
    await strip.page.fill('#cut-dash-left', '60');
    await strip.page.focus('#canvas');
    await strip.screenshot('strip-dashes');
    await strip.page.keyboard.press('Enter');
    await strip.until('k.numVertices > 1681');
    await strip.notice(/taken away/);
    const { cut } = await lastCut(kStrip);
    check(cut.view && cut.width_m === 0.025 && cut.dash.length === 2, `cut ${JSON.stringify(cut)}`);
    await strip.page.mouse.move(640, 5);
    await strip.screenshot('strip-dashes-cut');
    // The browser writes the refusal to the console.
    strip.errors = strip.errors.filter((error) => !error.includes('400'));
    check(strip.errors.length === 0, `console: ${strip.errors.join('; ')}`);
    await strip.page.close();
  });
}
