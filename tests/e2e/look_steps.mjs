// The look of a sheet, by the colours of pixels: cloth on a floor, colours that say something, what will be cut.
import { foldedScene } from './cutting_scenes.mjs';
import { check, post } from './harness.mjs';
import { ViewerPage } from './viewer_page.mjs';

const kWide = { viewport: { width: 1100, height: 700 }, colorScheme: 'light' };
const kFloor = { plane: { point: {}, normal: { z: 1 } }, friction: 0.5 };
const kGrid = { columns: 31, rows: 31, widthM: 1, heightM: 1 };

function laidFlat(z) {
  return { origin: { x: -0.5, y: -0.5, z }, xAxis: { x: 1 }, yAxis: { y: 1 } };
}

/** A paused sheet of this scene, and a page with it. */
async function openStill(browser, url, sheetId, scene, act = async () => {}) {
  await post(url, 'SheetService/CreateSheet', { sheetId, scene, paused: true });
  await act(`sheets/${sheetId}`);
  const { tick } = await post(url, 'SheetService/GetSheet', { name: `sheets/${sheetId}` });
  const viewer = await ViewerPage.open(browser, `${url}/?sheet=${sheetId}`, kWide);
  await viewer.untilDrawn('k.connection === "live" && k.isPaused && k.tick === given.tick', { tick: Number(tick) });
  await viewer.allDrawn();
  return viewer;
}

/** Material points, to each of which `isMeant` says yes, of a grid over the unit square. */
function gridPoints(side, isMeant = () => true) {
  const points = [];
  for (let i = 1; i < side; ++i) for (let j = 1; j < side; ++j) points.push([i / side, j / side]);
  return points.filter(([x, y]) => isMeant(x, y));
}

/** Colours of the page at material points, without cards over it. */
async function sheetColours(viewer, points, name) {
  const setCards = (visibility) =>
    viewer.page.evaluate((value) => {
      for (const card of document.querySelectorAll('.card')) card.style.visibility = value;
    }, visibility);
  const px = [];
  for (const [x, y] of points) px.push(await viewer.at(x, y));
  await setCards('hidden');
  const colours = await viewer.colours(px, name);
  await setCards('');
  return colours;
}

// A flat sheet, 8 % shorter along x than at rest where x < 0.5, and as much longer elsewhere, under a ball that shades it.
function strainedScene() {
  const side = 31;
  const numbers = Array.from({ length: side * side }, (_, i) => [i % side, Math.floor(i / side)].map((n) => n / (side - 1)));
  const squares = numbers.map(([x, y], i) => (x < 1 && y < 1 ? i : -1)).filter((i) => i >= 0);
  return {
    inline: {
      materialPositions: numbers.flat(),
      positions: numbers.flatMap(([x, y]) => [(x < 0.5 ? 0.92 : 1.08) * (x - 0.5), y - 0.5, 0.2]),
      triangles: squares.flatMap((i) => [i, i + 1, i + 1 + side, i, i + 1 + side, i + side]),
    },
    gravityMps2: {},
    colliders: [{ sphere: { center: { x: -0.35, y: -0.4, z: 1.0 }, radiusM: 0.25 } }],
  };
}

/** Colour of the page's scale of strains at a share of its width. */
async function colourOfScale(viewer, share) {
  const { x, y, width, height } = await viewer.page.locator('#strain-gradient').boundingBox();
  const [colour] = await viewer.colours([{ x: x + share * width, y: y + 0.5 * height }], 'strain-scale');
  return colour;
}

/** Checks that all of these are one colour of the legend, at most 15 % darker in linear light. */
function areOneColour(colours, ofLegend, what) {
  ofLegend.forEach((legend, k) => {
    const values = colours.map((colour) => colour[k]);
    const [least, most] = [Math.min(...values), Math.max(...values)];
    check(most - least <= 6, `${what}: a channel goes from ${least} to ${most}`);
    check(most <= legend + 4 && least >= 0.92 * legend - 4, `${what}: ${least} to ${most}, in the legend ${legend}`);
  });
}

function isNear(colour, other, tolerance) {
  return colour.every((value, k) => Math.abs(value - other[k]) <= tolerance);
}

function spread(colour) {
  return Math.max(...colour) - Math.min(...colour);
}

/** Checks that pixels have the colours of pieces, which the grey floor has not. */
async function areOfPieces(viewer, points, name) {
  const colours = await sheetColours(viewer, points, name);
  const grey = colours.filter((colour) => spread(colour) < 50).length;
  console.log(`         ${name}: ${grey} of ${points.length} points of the cloth are grey`);
  check(grey <= 0.01 * points.length, `${name}: the floor hides the cloth at ${grey} of ${points.length} points`);
}

async function isSeenOnFloor(viewer, points, name) {
  await viewer.page.keyboard.press('k');
  await viewer.until('k.isByPiece && k.pieceAt(given.x, given.y)', { x: points[0][0], y: points[0][1] });
  await areOfPieces(viewer, points, `${name}-mesh`);
  await viewer.page.keyboard.press('q');
  await viewer.until('k.picture?.connection === "live" && k.picture.isOfView');
  await areOfPieces(viewer, points, `${name}-picture`);
  check(viewer.errors.length === 0, `console: ${viewer.errors.join('; ')}`);
  await viewer.page.close();
}

export function lookSteps(steps, browser, { url }) {
  steps.step('a sheet that lies on the floor is seen, as in the picture of the server', async () => {
    const scene = { grid: kGrid, material: { preset: 'cotton' }, placement: laidFlat(0.002), colliders: [kFloor] };
    const viewer = await openStill(browser, url, 'lying', scene, (name) =>
      post(url, 'SheetService/StepSheet', { name, ticks: 90 }),
    );
    const { z } = await viewer.read('k.toWorld(0.5, 0.5)');
    check(z < 0.001, `the sheet is ${z} m above the floor`);
    await isSeenOnFloor(viewer, gridPoints(30), 'lying');
  });

  steps.step('a disc that was cut out and has landed on the floor is seen', async () => {
    const scene = {
      grid: kGrid,
      material: { preset: 'paper' },
      fidelity: 'REAL_TIME',
      placement: laidFlat(0.5),
      pins: [{ edge: 'CORNERS' }],
      colliders: [kFloor],
    };
    const [centre, radiusM] = [{ x: 0.5, y: 0.25 }, 0.15];
    const viewer = await openStill(browser, url, 'landed', scene, async (name) => {
      await post(url, 'CutService/CreateCut', { parent: name, cut: { curve: { circle: { center: centre, radiusM } } } });
      await post(url, 'SheetService/StepSheet', { name, ticks: 90 });
    });
    const { z } = await viewer.read('k.toWorld(0.5, 0.25)');
    check(z < 0.001, `the disc is ${z} m above the floor`);
    const isOnDisc = (x, y) => Math.hypot(x - centre.x, y - centre.y) < 0.9 * radiusM;
    await isSeenOnFloor(viewer, gridPoints(60, isOnDisc), 'landed');
  });

  steps.step('stretch and compression have the colours of the scale, without pattern, light and shadow', async () => {
    const viewer = await openStill(browser, url, 'strained', strainedScene());
    await viewer.page.keyboard.press('x');
    await viewer.until('k.numStrains > 0');
    await viewer.shows('#strain-ticks', '−10−50510 %');
    await viewer.allDrawn();
    const halves = [
      ['compressed', gridPoints(20, (x) => x > 0.05 && x < 0.45), 0.1],
      ['stretched', gridPoints(20, (x) => x > 0.55 && x < 0.95), 0.9],
    ];
    for (const [what, points, share] of halves) {
      areOneColour(await sheetColours(viewer, points, `strain-${what}`), await colourOfScale(viewer, share), what);
    }
    await viewer.page.keyboard.press('k');
    await viewer.until('k.isByPiece && k.numStrains === 0 && k.pieceAt(0.5, 0.5)');
    const all = gridPoints(20, (x, y) => x > 0.05 && x < 0.95 && y > 0.05 && y < 0.95);
    const colours = await sheetColours(viewer, all, 'flat-piece');
    areOneColour(colours, [0x00, 0x72, 0xb2], 'the only piece');
    check(viewer.errors.length === 0, `console: ${viewer.errors.join('; ')}`);
    await viewer.page.close();
  });

  steps.step('each part of a sheet looks like its material, as a mesh and in pictures, and after a cut', async () => {
    const region = { box: { min: { x: 0, y: 0 }, max: { x: 0.5, y: 1 } } };
    const scene = {
      grid: kGrid,
      material: { preset: 'paper' },
      materials: [{ region, material: { preset: 'rubber' } }],
      fidelity: 'REAL_TIME',
      placement: laidFlat(0.1),
      gravityMps2: {},
    };
    const circle = { center: { x: 0.5, y: 0.5 }, radiusM: 0.2 };
    const viewer = await openStill(browser, url, 'quilt', scene, (parent) =>
      post(url, 'CutService/CreateCut', { parent, cut: { curve: { circle } } }),
    );
    const isOffLips = (x, y) => Math.abs(Math.hypot(x - 0.5, y - 0.5) - 0.2) > 0.03;
    const drawn = { mesh: [], picture: [] };
    const areOfTheirMaterial = async (mode) => {
      for (const [name, isMeant] of [['rubber', (x) => x < 0.46 && x > 0.03], ['paper', (x) => x > 0.54 && x < 0.97]]) {
        const points = gridPoints(16, (x, y) => isMeant(x) && isOffLips(x, y));
        const colours = await sheetColours(viewer, points, `parts-${mode}-${name}`);
        drawn[mode].push(...colours);
        const lights = colours.map(([red, green, blue]) => (red + green + blue) / 3);
        const wrong = lights.filter((light) => (name === 'rubber' ? light > 120 : light < 150));
        check(wrong.length === 0, `${mode}: ${wrong.length} of ${points.length} points are not ${name}: ${wrong.map(Math.round)}`);
      }
    };
    await areOfTheirMaterial('mesh');
    await viewer.page.keyboard.press('q');
    await viewer.until('k.picture?.connection === "live" && k.picture.isOfView');
    await areOfTheirMaterial('picture');
    const unlike = drawn.mesh.filter((colour, i) => !isNear(colour, drawn.picture[i], 24)).length;
    console.log(`         ${unlike} of ${drawn.mesh.length} points differ by more than 24 of 255 between mesh and picture`);
    check(unlike <= 0.05 * drawn.mesh.length, `mesh and picture differ at ${unlike} of ${drawn.mesh.length} points`);
    check(viewer.errors.length === 0, `console: ${viewer.errors.join('; ')}`);
    await viewer.page.close();
  });

  steps.step('a page that draws too slowly draws more coarsely, but what is still, and offers pictures', async () => {
    const scene = { grid: kGrid, placement: laidFlat(1), pins: [{ edge: 'TOP_CORNERS' }] };
    await post(url, 'SheetService/CreateSheet', { sheetId: 'swinging', scene });
    // Less than seven drawings a second.
    const viewer = await ViewerPage.open(browser, `${url}/?sheet=swinging`, { ...kWide, frameMs: 150, isAdaptive: true });
    const hasWidth = (px) => viewer.until('document.querySelector("#canvas").width === given.px', { px });
    await hasWidth(kWide.viewport.width / 2);
    const offer = viewer.page.locator('.notice.offer', { hasText: /^Drawing is slow (without a graphics card|in this browser)/ });
    await offer.waitFor();
    await viewer.screenshot('coarse');
    await viewer.page.keyboard.press(' ');
    await viewer.until('k.isPaused');
    await hasWidth(kWide.viewport.width);
    await viewer.shows('#status-fps', 'paused');
    await viewer.shows('#status-age', 'current');
    const isCoarse = hasWidth(kWide.viewport.width / 2);
    await viewer.page.keyboard.press('ArrowLeft');
    await isCoarse;
    await hasWidth(kWide.viewport.width);
    await offer.getByRole('button', { name: 'Let the server draw' }).click();
    await viewer.until('k.picture?.connection === "live"');
    check((await offer.count()) === 0, 'the offer is still there');
    check(viewer.errors.length === 0, `console: ${viewer.errors.join('; ')}`);
    await viewer.page.close();
  });

  steps.step('what is drawn on the material bends with the sheet, and is faint where a fold hides it', async () => {
    const viewer = await openStill(browser, url, 'bent', foldedScene());
    await viewer.page.keyboard.press('k');
    await viewer.until('k.isByPiece && k.pieceAt(0.5, 0.5)');
    await viewer.choose('cut');
    await viewer.page.keyboard.press('5');
    await viewer.page.keyboard.press('i');
    // Down the half in front and up the one behind it, whose upper part is seen.
    await viewer.tap(0.5, 0.15);
    await viewer.tap(0.5, 0.95);
    const along = (...ys) => ys.map((y) => [0.5, y]);
    const isFaintBehind = async (where) => {
      const seen = await sheetColours(viewer, along(0.25, 0.35, 0.45, 0.85), `preview-seen-${where}`);
      for (const colour of seen) check(isNear(colour, [255, 210, 63], 30), `${where}: a part that is seen is ${colour}`);
      const hidden = await sheetColours(viewer, along(0.6, 0.65, 0.7), `preview-hidden-${where}`);
      for (const [red, green, blue] of hidden) {
        const isFaint = red > 60 && red < 150 && green > 110 && blue > 100;
        check(isFaint, `${where}: a part that is hidden is ${[red, green, blue]}`);
      }
    };
    await isFaintBehind('mesh');
    await viewer.page.keyboard.press('q');
    await viewer.until('k.picture?.connection === "live" && k.picture.isOfView');
    await isFaintBehind('picture');
    await viewer.page.keyboard.press('q');
    await viewer.page.keyboard.press('Escape');
    await viewer.allDrawn();
    const left = await sheetColours(viewer, along(0.25, 0.35, 0.6, 0.65), 'preview-gone');
    for (const colour of left) check(colour[0] < 40, `without a drawing the sheet is ${colour}`);
    check(viewer.errors.length === 0, `console: ${viewer.errors.join('; ')}`);
    await viewer.page.close();
  });
}
