// Cuts with a width: what was pinned, held and coloured where the material goes, and what is there when it is back.
import { kFlatScene, kTall, lastCut } from './cutting_scenes.mjs';
import { check, post } from './harness.mjs';
import { ViewerPage } from './viewer_page.mjs';

export function stripSteps(steps, browser, { url }) {
  const kStrip = 'sheets/strip';
  const kMiddle = 840; // of 41 x 41 vertices
  let strip;
  const background = async (...points) => {
    const px = [];
    for (const [x, y] of points) px.push(await strip.at(x, y));
    return strip.colours(px, 'strip-colours');
  };
  const isRed = ([red, green, blue]) => red > green + 40 && red > blue + 40;

  steps.step('a cut with a width shows its strip, takes it away and says how much', async () => {
    const scene = { ...kFlatScene, pins: [{ vertices: { vertices: [0, kMiddle] } }] };
    await post(url, 'SheetService/CreateSheet', { sheetId: 'strip', scene, paused: true });
    strip = await ViewerPage.open(browser, `${url}/?sheet=strip`, kTall);
    await strip.untilDrawn('k.connection === "live" && k.isPaused && k.framesDrawn > 0 && k.pinnedVertices.length === 2');
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
    await strip.notice(/^Cut: 1 piece, 530 cm² removed/);
    const { cut, result } = await lastCut(url, kStrip);
    check(cut.width_m === 0.08 && !cut.view, `cut ${JSON.stringify(cut)}`);
    check(Math.abs(result.removed.area_m2 - (0.08 * 0.6 + Math.PI * 0.04 ** 2)) < 2e-4, `took ${result.removed.area_m2}`);
    await strip.until('k.pinnedVertices.length === 1');
    await strip.page.mouse.move(640, 5);
    await strip.screenshot('strip-cut');
  });

  steps.step('vertices without material disturb neither grab, pieces, wireframe, fit nor undo', async () => {
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

  steps.step('one piece is chosen by a tap, and the last drawing is laid again', async () => {
    const ring = { curve: { circle: { center: { x: 0.6, y: 0.25 }, radiusM: 0.15 } }, widthM: 0.05 };
    await post(url, 'CutService/CreateCut', { parent: kStrip, cut: ring });
    await strip.until('k.pieces === 2');
    await strip.choose('cut');
    await strip.page.keyboard.press('3');
    await strip.page.fill('#cut-width', '0');
    await strip.shows('#cut-piece-shown', 'the one the line meets first');
    await strip.page.click('#cut-piece-choose');
    await strip.shows('#cut-prompt', 'Click the piece to cut');
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
    const { cut, result } = await lastCut(url, kStrip);
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
    const { cut: again, result: other } = await lastCut(url, kStrip);
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

  steps.step('a drawing of thousands of shapes shows all of its strip', async () => {
    const squares = Array.from({ length: 6000 }, (_, i) => `<path d="M${i % 80} ${Math.floor(i / 80)}h.5v.5h-.5z"/>`);
    // 180 x 80 units are fitted to 0.9 m x 0.4 m.
    const last = '<rect x="120" y="20" width="60" height="60"/>';
    const text = `<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 200 100">${squares.join('')}${last}</svg>`;
    await strip.choose('cut');
    await strip.page.setInputFiles('#svg-file', { name: 'many.svg', mimeType: 'image/svg+xml', buffer: Buffer.from(text) });
    await strip.page.locator('#cut-prompt', { hasText: 'many.svg' }).waitFor();
    await strip.page.fill('#cut-width', '40');
    await strip.page.mouse.move(640, 5);
    const sides = [[0.8, 0.6], [0.8, 0.315], [0.935, 0.45], [0.65, 0.45]];
    const seen = await background(...sides, [0.2, 0.42], [0.8, 0.45]);
    const middle = seen.pop();
    check(seen.every(isRed) && !isRed(middle), `its sides are ${seen.join(' and ')}, within them is ${middle}`);
    await strip.page.focus('#canvas');
    await strip.page.keyboard.press('Escape');
  });

  steps.step('a dashed strip on the picture is cut, and one that takes all is refused in words', async () => {
    await strip.choose('cut');
    await strip.page.keyboard.press('1');
    await strip.page.keyboard.press('o');
    await strip.drag(await strip.at(0.5, 0.5), await strip.at(0.75, 0.5));
    await strip.page.mouse.up();
    await strip.page.fill('#cut-width', '5000');
    await strip.page.click('#cut-apply');
    await strip.notice(/^Nothing was cut: the strip would remove the whole sheet; [^()]*$/);
    await strip.page.fill('#cut-width', '25');
    await strip.page.check('#cut-dashed');
    await strip.page.fill('#cut-dash-cut', '60');
    await strip.page.fill('#cut-dash-left', '60');
    await strip.page.focus('#canvas');
    await strip.screenshot('strip-dashes');
    await strip.page.keyboard.press('Enter');
    await strip.until('k.numVertices > 1681');
    await strip.notice(/^Cut: .* removed/);
    const { cut } = await lastCut(url, kStrip);
    check(cut.view && cut.width_m === 0.025 && cut.dash.length === 2, `cut ${JSON.stringify(cut)}`);
    await strip.page.mouse.move(640, 5);
    await strip.screenshot('strip-dashes-cut');
    // The browser writes the refusal to the console.
    strip.errors = strip.errors.filter((error) => !error.includes('400'));
    check(strip.errors.length === 0, `console: ${strip.errors.join('; ')}`);
    await strip.page.close();
  });
}
