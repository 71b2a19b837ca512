// The cut tool on two sheets that nothing moves.
import { foldedScene, kFlatScene, kTall, lastCut } from './cutting_scenes.mjs';
import { check, post } from './harness.mjs';
import { ViewerPage } from './viewer_page.mjs';

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
/** Drawing on the picture and on the material, every kind of drawing, and the colours of the pieces. */
export function cuttingSteps(steps, browser, { url }) {
  let fold;
  let flat;

  steps.step('what is seen is cut, or every layer, or the material', async () => {
    await post(url, 'SheetService/CreateSheet', { sheetId: 'fold', scene: foldedScene() });
    await post(url, 'SheetService/PauseSheet', { name: kFold });
    fold = await ViewerPage.open(browser, `${url}/?sheet=fold`, kTall);
    await fold.untilDrawn('k.connection === "live" && k.isPaused && k.numVertices > 0');
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
      const { cut, result } = await lastCut(url, kFold);
      check(cut.view?.layers === layers, `key ${key} cut ${JSON.stringify(cut.view?.layers)}`);
      check(result.layers.length === stretches, `${layers} cut ${result.layers.length} stretches, not ${stretches}`);
      if (key === '2') await fold.screenshot('cut-layers');
      await fold.page.keyboard.press('Control+z');
      await fold.until('k.topologyVersion > given.version', { version: version + 1 });
    }
    await fold.page.keyboard.press('5');
    await tapLine();
    await fold.page.keyboard.press('Enter');
    await fold.notice(/^Cut: \d+ piece/);
    const { cut } = await lastCut(url, kFold);
    const [first] = cut.curve.polyline.points;
    check(!cut.view && Math.hypot(first.x - 0.3, first.y - 0.25) < 0.01, `on the material: ${JSON.stringify(cut)}`);
    await fold.page.keyboard.press('1');
    await fold.page.keyboard.press('Control+z');
    await fold.until('k.numVertices === 961');
  });

  steps.step('a point of a curve gets a weight, and the curve is rational', async () => {
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
    const { cut } = await lastCut(url, kFold);
    const { weights } = cut.curve.path.subpaths[0].segments[0].quadratic;
    check(Math.abs(weights[1] / weights[0] - 8) < 1e-9, `weights ${weights}`);
    await fold.page.keyboard.press('Control+z');
    await fold.until('k.numVertices === 961');
  });

  steps.step('circle, ellipse and a dashed freehand loop are drawn by a drag', async () => {
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
      const { cut } = await lastCut(url, kFold);
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
    const { cut, result } = await lastCut(url, kFold);
    const [{ start, segments, closed }] = cut.curve.path.subpaths;
    const last = segments.at(-1).cubic.end;
    check(closed && start.x === last.x && start.y === last.y, 'the loop is not closed');
    check(cut.dash[0] === 0.03 && cut.dash[1] === 0.015, `dashes ${cut.dash}`);
    check(result.pieces === 3, `a perforated loop falls out: ${result.pieces} pieces`);
    await fold.page.keyboard.press('d');
    check(!(await fold.page.isChecked('#cut-dashed')), 'D does not switch dashes off');
    await fold.page.mouse.move(640, 5);
    await fold.screenshot('cut-all');
    check(fold.errors.length === 0, `console: ${fold.errors.join('; ')}`);
    await fold.page.close();
  });

  steps.step('an SVG file is dropped on the sheet, moved, scaled and cut', async () => {
    await post(url, 'SheetService/CreateSheet', { sheetId: 'flat', scene: kFlatScene, paused: true });
    flat = await ViewerPage.open(browser, `${url}/?sheet=flat`, kTall);
    await flat.untilDrawn('k.connection === "live" && k.isPaused && k.framesDrawn > 0');
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
    await flat.notice(/^Cut: 6 pieces/);
    await flat.notice(/text/);
    const { cut } = await lastCut(url, 'sheets/flat');
    const { min, max } = cut.fit;
    const wanted = [0.15, 0.487, 0.87, 0.828];
    const off = [min.x, min.y, max.x, max.y].map((value, i) => Math.abs(value - wanted[i]));
    check(Math.max(...off) < 0.01, `cut in ${JSON.stringify(cut.fit)}`);
    await flat.screenshot('svg-cut');
  });

  steps.step('an SVG file is chosen, and what is none is refused in words', async () => {
    const choosing = flat.page.waitForEvent('filechooser');
    await flat.page.keyboard.press('Control+z');
    await flat.until('k.pieces === 1');
    await flat.page.setInputFiles('#svg-file', { name: 'notes.txt', mimeType: 'text/plain', buffer: Buffer.from('x') });
    await flat.notice(/notes.txt is neither SVG nor DXF/);
    await flat.page.setInputFiles('#svg-file', {
      name: 'large.svg',
      mimeType: 'image/svg+xml',
      buffer: Buffer.alloc(512 * 1024 + 1, ' '),
    });
    await flat.notice(/large.svg has 513 KiB; the server accepts drawings of at most 512/);
    await flat.page.keyboard.press('s');
    const chooser = await choosing;
    await chooser.setFiles({ name: 'broken.svg', mimeType: 'image/svg+xml', buffer: Buffer.from('<svg><path') });
    await flat.notice(/^broken.svg is broken: its text ends early or has an error in line 1/);
    check(await flat.page.isDisabled('#cut-apply'), 'a broken drawing is offered to be cut');
    await flat.screenshot('svg-broken');
    await flat.page.keyboard.press('Escape');
    check(flat.errors.length === 0, `console: ${flat.errors.join('; ')}`);
  });

  steps.step('pieces have colours that they keep while others are cut', async () => {
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

  steps.step('a cut that would end real time is warned of before it is made, and in its reply', async () => {
    const scene = {
      ...kFlatScene,
      grid: { columns: 50, rows: 50, widthM: 1, heightM: 1 },
      pins: [{ edge: 'TOP' }],
      material: { preset: 'wool' },
      fidelity: 'REAL_TIME',
    };
    await post(url, 'SheetService/CreateSheet', { sheetId: 'stiff', scene, paused: true });
    const stiff = await ViewerPage.open(browser, `${url}/?sheet=stiff`, kTall);
    await stiff.untilDrawn('k.connection === "live" && k.isPaused && k.framesDrawn > 0');
    await stiff.choose('cut');
    await stiff.page.keyboard.press('i');
    for (const [x, y] of [[0.3, 0.45], [0.5, 0.55], [0.7, 0.45]]) await stiff.tap(x, y);
    const warning = stiff.page.locator('#cut-warning', { hasText: /This cut slows the sheet to \d+ % of its speed/ });
    await warning.waitFor();
    await stiff.screenshot('cut-warning');
    check((await stiff.read('({ version: k.topologyVersion })')).version === 1, 'the sheet was cut');
    // It is another cut, seen from nearer by.
    const again = stiff.page.waitForRequest('**/kerf.v1.CutService/CreateCut');
    await stiff.page.mouse.move(640, 5);
    await stiff.page.mouse.wheel(0, -60);
    check(JSON.parse((await again).postData()).validateOnly, 'the sheet is cut where the view changes');
    await warning.waitFor();
    await stiff.page.keyboard.press('Enter');
    await stiff.notice(/The sheet now falls behind/);
    check(!(await warning.isVisible()), 'the warning of a cut that was made stays');
    const { tick_estimate: tick } = await post(url, 'SheetService/GetSheet', { name: 'sheets/stiff' });
    check(tick.total_us > tick.budget_us, `ticks fit: ${JSON.stringify(tick)}`);
    check(/Remedy/.test(tick.advice), `no advice: ${tick.advice}`);
    await stiff.page.close();
    await post(url, 'SheetService/DeleteSheet', { name: 'sheets/stiff' });
  });

  steps.step('the component that is seen is cut, in the coordinates of the whole', async () => {
    const upright = { xAxis: { x: 1 }, yAxis: { z: 1 } };
    const scene = {
      components: [
        { name: 'cloth', grid: { columns: 21, rows: 21, widthM: 1, heightM: 1 }, placement: upright },
        // Right in front of the cloth.
        { name: 'ribbon', grid: { columns: 21, rows: 5, widthM: 1, heightM: 0.2 },
          placement: { ...upright, origin: { y: -0.05, z: 0.4 } }, material: { preset: 'silk' } },
      ],
      gravityMps2: {},
    };
    await post(url, 'SheetService/CreateSheet', { sheetId: 'pair', scene, paused: true });
    const pair = await ViewerPage.open(browser, `${url}/?sheet=pair`, kTall);
    await pair.untilDrawn('k.connection === "live" && k.isPaused && k.framesDrawn > 0');
    await pair.choose('cut');
    for (const [x, y] of [[1.4, 0.05], [1.5, 0.15], [1.6, 0.05]]) await pair.tap(x, y);
    await pair.screenshot('cut-component');
    await pair.page.keyboard.press('Enter');
    await pair.until('k.topologyVersion > 1');
    const { result } = await lastCut(url, 'sheets/pair');
    check(result.layers.length === 1 && result.layers[0].piece === 1, `not the ribbon: ${JSON.stringify(result.layers)}`);
    await pair.page.keyboard.press('5');
    await pair.page.keyboard.press('i');
    for (const [x, y] of [[0.3, 0.8], [0.6, 0.85]]) await pair.tap(x, y);
    await pair.page.keyboard.press('Enter');
    await pair.until('k.topologyVersion > 2');
    const { cut } = await lastCut(url, 'sheets/pair');
    const [first] = cut.curve.polyline.points;
    check(!cut.view && Math.hypot(first.x - 0.3, first.y - 0.8) < 0.01, `on the material: ${JSON.stringify(cut)}`);
    check((await pair.page.locator('#material-part option').allTextContents()).includes('ribbon'), 'no part is the ribbon');
    await pair.page.keyboard.press('1');
    check(pair.errors.length === 0, `console: ${pair.errors.join('; ')}`);
    await pair.page.close();
    await post(url, 'SheetService/DeleteSheet', { name: 'sheets/pair' });
  });
}
