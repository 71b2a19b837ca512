// What acts on a sheet and what it is made of: gravity, wind, pins, pieces, each looked up on the server.
import { check, kPatienceMs, post } from './harness.mjs';
import { ViewerPage } from './viewer_page.mjs';

const kSheet = { name: 'sheets/physics' };
const kScene = {
  grid: { columns: 21, rows: 21, widthM: 1, heightM: 1 },
  placement: { origin: { x: -0.5, z: 0.2 }, xAxis: { x: 1 }, yAxis: { y: Math.cos(0.7), z: Math.sin(0.7) } },
  pins: [{ edge: 'TOP_CORNERS' }],
};

export async function physicsSteps(steps, browser, url) {
  const sheet = () => post(url, 'SheetService/GetSheet', kSheet);
  let viewer;
  // Asks the server until it has what was asked for: the page does not wait for the answer to its call.
  const serverHas = async (what, isSo) => {
    const deadline = Date.now() + kPatienceMs;
    let last;
    do last = await sheet();
    while (!isSo(last) && Date.now() < deadline);
    check(isSo(last), `${what}: the server has ${JSON.stringify({ ...last.scene, pins: last.pinned_vertices })}`);
  };
  const gravityIs = (z) => serverHas('gravity', ({ scene }) => (scene.gravity_mps2?.z ?? 0) === z);

  await steps.step('gravity is set by a slider, by keys and by a button', async () => {
    await post(url, 'SheetService/CreateSheet', { sheetId: 'physics', scene: kScene, paused: true });
    const options = { viewport: { width: 1280, height: 720 }, colorScheme: 'light' };
    viewer = await ViewerPage.open(browser, `${url}/?sheet=physics`, options);
    await viewer.until('k.connection === "live" && k.isPaused && k.framesDrawn > 0');
    await viewer.page.keyboard.press('m');
    await viewer.page.click('[data-gravity="1.62"]');
    await gravityIs(-1.62);
    await viewer.page.fill('#gravity', '5');
    await gravityIs(-5);
    await viewer.page.focus('#gravity');
    await viewer.page.keyboard.press('ArrowRight');
    await gravityIs(-5.01);
    await viewer.shows('#gravity-value', '5.01 m/s²');
  });

  await steps.step('wind blows as strong and in the direction that is asked for, and stops', async () => {
    await viewer.page.fill('#wind-speed', '8');
    await viewer.page.fill('#wind-azimuth', '180');
    const blows = ({ scene: { wind } }) => {
      const { x = 0, y = 0, z = 0 } = wind?.velocity_mps ?? {};
      return Math.abs(x + 8) < 1e-9 && Math.abs(y) < 1e-9 && Math.abs(z) < 1e-9;
    };
    await serverHas('wind', blows);
    check(await viewer.page.isChecked('#wind-on'), 'air is not on though it blows');
    await viewer.shows('#wind-speed-value', '8.0 m/s');
    const facts = await viewer.page.textContent('#material-facts');
    check(facts.includes('400 kPa') && facts.includes('200 g/m²'), `the preset demo is shown as ${facts}`);
    await viewer.screenshot('physics');
    await viewer.page.uncheck('#wind-on');
    await serverHas('no wind', ({ scene }) => scene.wind === undefined);
    // What another viewer sets is shown here, too.
    const wind = { velocityMps: { y: 3 }, airDensityKgpm3: 1.2, dragCoefficient: 1 };
    await post(url, 'InteractionService/SetSheetWind', { ...kSheet, setWind: { wind } });
    await viewer.shows('#wind-speed-value', '3.0 m/s');
    await viewer.shows('#wind-azimuth-value', '90°');
  });

  await steps.step('an edge is held, and then nothing', async () => {
    await viewer.page.selectOption('#pin-choice', { label: 'left edge' });
    await viewer.page.click('#pin-apply');
    await viewer.shows('#pin-count', '21 vertices held');
    await serverHas('the left edge', ({ pinned_vertices: pins }) => pins.length === 21 && pins.every((v) => v % 21 === 0));
    await viewer.page.selectOption('#pin-choice', { label: 'nothing' });
    await viewer.page.click('#pin-apply');
    await viewer.shows('#pin-count', '0 vertices held');
    await serverHas('no pins', ({ pinned_vertices: pins }) => !pins?.length);
  });

  await steps.step('pieces are listed with their sizes, light up and come into the middle', async () => {
    const curve = { polyline: { points: [{ x: 0.3, y: -0.1 }, { x: 0.3, y: 1.1 }] } };
    await post(url, 'CutService/CreateCut', { parent: kSheet.name, cut: { curve } });
    await viewer.until('k.pieces === 2');
    await viewer.page.click('[data-panel=pieces]');
    await viewer.page.locator('#piece-list li').nth(1).waitFor();
    const { pieces } = await post(url, 'CutService/ListPieces', { parent: kSheet.name });
    const larger = pieces.find(({ area_m2: area }) => area > 0.5);
    const first = viewer.page.locator('#piece-list button').first();
    const text = await first.textContent();
    check(text.includes(`Piece ${larger.id}`) && text.includes('7,000 cm²'), `the first of ${pieces.length} is ${text}`);
    const at = await viewer.at(0.65, 0.5);
    const [before] = await viewer.colours([at], 'pieces-plain');
    const drawn = await viewer.read('k.framesDrawn');
    await first.hover();
    await viewer.until('k.framesDrawn > given.drawn', { drawn });
    const [lit] = await viewer.colours([at], 'pieces-lit');
    check(lit.some((value, i) => Math.abs(value - before[i]) > 30), `lit up it is ${lit}, before ${before}`);
    await first.click();
    await viewer.until('Math.hypot(k.toClient(0.65, 0.5).x - 640, k.toClient(0.65, 0.5).y - 360) < 12');
    await viewer.screenshot('pieces-centred');
    check(viewer.errors.length === 0, `console: ${viewer.errors.join('; ')}`);
    await viewer.page.close();
  });
}
