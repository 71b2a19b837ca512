// Influences on a sheet and its material: gravity, wind, pins, pieces, each looked up on the server.
import { check, kPatienceMs, post } from './harness.mjs';
import { ViewerPage } from './viewer_page.mjs';

const kSheet = { name: 'sheets/physics' };
const kWindColour = [0x2f, 0x86, 0xd6];
const kScene = {
  grid: { columns: 21, rows: 21, widthM: 1, heightM: 1 },
  placement: { origin: { x: -0.5, z: 0.2 }, xAxis: { x: 1 }, yAxis: { y: Math.cos(0.7), z: Math.sin(0.7) } },
  pins: [{ edge: 'TOP_CORNERS' }],
};

export function physicsSteps(steps, browser, { url }) {
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

  steps.step('gravity is set by a slider, by keys and by a button', async () => {
    await post(url, 'SheetService/CreateSheet', { sheetId: 'physics', scene: kScene, paused: true });
    const options = { viewport: { width: 1280, height: 720 }, colorScheme: 'light' };
    viewer = await ViewerPage.open(browser, `${url}/?sheet=physics`, options);
    await viewer.untilDrawn('k.connection === "live" && k.isPaused && k.framesDrawn > 0');
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

  steps.step('what was answered before a change is not shown after it', async () => {
    const { answered, release } = await viewer.holdAnswer('SheetService/GetSheet');
    const setGravity = { gravityMps2: { z: -3 } };
    await post(url, 'InteractionService/SetSheetGravity', { ...kSheet, setGravity });
    await answered;
    const newest = viewer.page.waitForResponse('**/kerf.v1.SheetService/GetSheet');
    await viewer.page.fill('#gravity', '7');
    const texts = await viewer.textsOf('#gravity-value');
    await (await newest).finished();
    await gravityIs(-7);
    await release();
    await viewer.page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
    const shown = await texts.jsonValue();
    check(shown.every((text) => text === '7.00 m/s²'), `after 7 was set, the page showed ${shown.join(', ')}`);
  });

  steps.step('wind blows as strong and in the direction that is asked for, and stops', async () => {
    await viewer.page.fill('#wind-speed', '8');
    await viewer.page.fill('#wind-azimuth', '180');
    const blows = ({ scene: { wind } }) => {
      const { x = 0, y = 0, z = 0 } = wind?.velocity_mps ?? {};
      return Math.abs(x + 8) < 1e-9 && Math.abs(y) < 1e-9 && Math.abs(z) < 1e-9;
    };
    await serverHas('wind', blows);
    check(await viewer.page.isChecked('#wind-on'), 'air is not on though it blows');
    await viewer.shows('#wind-speed-value', '8.0 m/s');
    await viewer.screenshot('physics');
    const numArrow = await viewer.numPixels(kWindColour, 'wind');
    await viewer.page.uncheck('#wind-on');
    await serverHas('no wind', ({ scene }) => scene.wind === undefined);
    await viewer.screenshot('no-wind');
    const numLeft = await viewer.numPixels(kWindColour, 'no-wind');
    check(numArrow > numLeft + 50, `${numArrow} pixels of the wind's colour while it blows, then ${numLeft}`);
    // Settings made by another viewer are shown here, too.
    const wind = { velocityMps: { y: 3 }, airDensityKgpm3: 1.2, dragCoefficient: 1 };
    await post(url, 'InteractionService/SetSheetWind', { ...kSheet, setWind: { wind } });
    await viewer.shows('#wind-speed-value', '3.0 m/s');
    await viewer.shows('#wind-azimuth-value', '90°');
  });

  steps.step('an edge is held, and then nothing', async () => {
    await viewer.page.selectOption('#pin-choice', { label: 'left edge' });
    await viewer.page.click('#pin-apply');
    await viewer.shows('#pin-count', '21 vertices held');
    await serverHas('the left edge', ({ pinned_vertices: pins }) => pins.length === 21 && pins.every((v) => v % 21 === 0));
    await viewer.page.selectOption('#pin-choice', { label: 'nothing' });
    await viewer.page.click('#pin-apply');
    await viewer.shows('#pin-count', '0 vertices held');
    await serverHas('no pins', ({ pinned_vertices: pins }) => !pins?.length);
  });

  const field = (id) => viewer.page.locator(`#material-${id}-value`);
  const fieldShows = (id, text) =>
    viewer.page.waitForFunction(([name, wanted]) => document.getElementById(`material-${name}-value`).value === wanted, [id, text]);
  const materialIs = (what, isSo) => serverHas(what, ({ scene }) => isSo(scene.material));

  steps.step('the material is set by sliders, numbers and presets, and is that of the server', async () => {
    await fieldShows('stiffness', '400 kPa');
    await viewer.shows('#material-mass', '200 g/m²');
    check((await viewer.page.inputValue('#material-preset')) === 'demo', 'the preset of the sheet is not shown');
    await viewer.page.locator('#material-stiffness').scrollIntoViewIfNeeded();
    // Dragged to its right end: every value on the way may be sent, the last one must be.
    const box = await viewer.page.locator('#material-stiffness').boundingBox();
    const middle = box.y + box.height / 2;
    await viewer.drag({ x: box.x + 0.3 * box.width, y: middle }, { x: box.x + 0.6 * box.width, y: middle });
    const dragged = await field('stiffness').inputValue();
    await viewer.page.mouse.up();
    const [, digits, prefix] = /^([\d.]+) ([kM])Pa$/.exec(dragged);
    const modulus = Number(digits) * (prefix === 'k' ? 1e3 : 1e6);
    check(modulus > 1e6, `dragged to ${dragged}`);
    const isNear = (value, wanted) => Math.abs(value / wanted - 1) < 1e-9;
    // The ratio of the moduli is kept.
    await materialIs('the dragged stiffness', (material) =>
      isNear(material.youngs_modulus_pa, modulus) &&
      isNear(material.youngs_modulus_2_pa, modulus) &&
      isNear(material.shear_modulus_pa, 1.5385e5 * (modulus / 4e5)),
    );
    check((await viewer.page.inputValue('#material-preset')) === '', 'own numbers are shown as a preset');
    await viewer.page.focus('#material-thickness');
    await viewer.page.keyboard.press('ArrowRight');
    await materialIs('thickness by a key', (material) => isNear(material.thickness_m, 5.31e-4));
    await field('bending').fill('9e-6');
    await field('bending').press('Enter');
    await fieldShows('bending', '9 µN m');
    await materialIs('bending as typed', ({ youngs_modulus_pa: e, thickness_m: t, bending_scale: scale }) =>
      isNear((scale * e * t ** 3) / (12 * (1 - 0.3 * 0.3)), 9e-6),
    );
    await viewer.screenshot('material');
    await viewer.page.selectOption('#material-preset', 'cotton');
    await materialIs('cotton', (material) => material.density_kgpm3 === 375 && material.youngs_modulus_2_pa === 3e7);
    await fieldShows('across', '30 MPa');
  });

  steps.step('what is no number is told while the server takes what was chosen before', async () => {
    const { asked, release } = await viewer.hold('InteractionService/SetSheetMaterial');
    await viewer.page.selectOption('#material-preset', 'denim');
    await asked;
    await field('density').fill('heavy');
    await field('density').press('Enter');
    const error = viewer.page.locator('#material-density-error', { hasText: /^Give Density as a number/ });
    await error.waitFor();
    const settings = viewer.page.waitForResponse('**/kerf.v1.SheetService/GetSheet');
    await release();
    await (await settings).finished();
    await viewer.page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
    check(await error.isVisible(), 'settings that are older than an error take it away');
    await field('density').press('Escape');
    await viewer.page.selectOption('#material-preset', 'cotton');
    await materialIs('cotton once more', (material) => material.density_kgpm3 === 375);
    await fieldShows('density', '375 kg/m³');
  });

  steps.step('what is no number, and what the server refuses, is told at the number, and another viewer is followed', async () => {
    await field('density').fill('heavy');
    await field('density').press('Enter');
    await viewer.page.locator('#material-density-error', { hasText: /^Give Density as a number, such as / }).waitFor();
    check((await field('density').getAttribute('aria-invalid')) === 'true', 'the field is not marked');
    await field('density').press('Escape');
    check((await field('density').inputValue()) === '375 kg/m³', 'Escape does not take back what was typed');
    check(await viewer.page.isVisible('#panel-physics'), 'Escape in a field that was typed in closes the panel');
    await field('thickness').fill('2 m');
    await field('thickness').press('Enter');
    const refusal = viewer.page.locator('#material-thickness-error', { hasText: /^Thickness is 2; choose a value from/ });
    await refusal.waitFor();
    await fieldShows('thickness', '400 µm');
    await viewer.screenshot('material-refused');
    const setMaterial = { material: { preset: 'silk' } };
    await post(url, 'InteractionService/SetSheetMaterial', { ...kSheet, setMaterial });
    await fieldShows('thickness', '120 µm');
    check(await viewer.page.isHidden('#material-thickness-error'), 'a refusal stays though the material is another one');
    check((await viewer.page.inputValue('#material-preset')) === 'silk', 'what another viewer chose is not shown');
    viewer.errors = viewer.errors.filter((error) => !/400/.test(error));
  });

  steps.step('the speed is set by keys and by choice, and another client’s is shown', async () => {
    const speedIs = (wanted) => serverHas(`speed ${wanted}`, ({ speed }) => speed === wanted);
    const chosen = (text) =>
      viewer.page.waitForFunction((wanted) => document.getElementById('speed').selectedOptions[0]?.textContent === wanted, text);
    await viewer.page.focus('#canvas');
    await viewer.page.keyboard.press('<');
    await viewer.page.keyboard.press('<');
    await speedIs(0.25);
    await chosen('1/4 ×');
    await viewer.page.selectOption('#speed', { label: '1/16 ×' });
    await speedIs(1 / 16);
    await viewer.screenshot('slow-motion');
    await viewer.page.focus('#canvas');
    await viewer.page.keyboard.press('>');
    await speedIs(1 / 8);
    await post(url, 'SheetService/SetSheetSpeed', { ...kSheet, speed: 0.2 });
    await chosen('0.2 ×');
    await viewer.page.keyboard.press('0');
    await speedIs(1);
    await chosen('1 ×');
  });

  steps.step('what a call for one sheet answers is not taken for another that is shown by then', async () => {
    const { asked, release } = await viewer.hold('SheetService/StepSheet');
    await viewer.page.keyboard.press('.');
    await asked;
    await viewer.pick('demo');
    await viewer.until('k.sheet === "sheets/demo" && k.connection === "live" && k.pinnedVertices.length === 2');
    await release();
    await viewer.page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
    const { length } = await viewer.read('k.pinnedVertices');
    check(length === 2, `the demo sheet is shown with ${length} pins, as the one that was stepped has`);
    await viewer.pick('physics');
    await viewer.until('k.sheet === "sheets/physics" && k.connection === "live" && k.isPaused');
  });

  steps.step('pieces are listed with their sizes, light up and come into the middle', async () => {
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
  });

  steps.step('a state is saved under a name, restored after a cut, and deleted', async () => {
    await viewer.page.keyboard.press('Escape');
    await viewer.page.focus('#canvas');
    await viewer.page.keyboard.press('y');
    await viewer.page.locator('#state-list-empty').waitFor();
    await viewer.page.fill('#state-name', 'before-it');
    await viewer.page.click('#state-form button');
    const row = viewer.page.locator('#state-list li');
    await row.waitFor();
    const tick = await viewer.read('k.tick');
    const told = await row.textContent();
    check(told.includes('before-it') && told.includes('vertices'), `the row says ${told}`);
    const [saved] = (await post(url, 'SheetService/ListStates', { parent: kSheet.name })).states;
    check(saved.name === `${kSheet.name}/states/before-it` && Number(saved.tick) === tick, `saved as ${saved.name}`);
    const curve = { polyline: { points: [{ x: 0.7, y: -0.1 }, { x: 0.7, y: 1.1 }] } };
    await post(url, 'CutService/CreateCut', { parent: kSheet.name, cut: { curve } });
    await post(url, 'SheetService/StepSheet', { ...kSheet, ticks: 5 });
    await viewer.until('k.pieces === 3 && k.tick === given.tick + 5', { tick });
    await row.locator('.open').click();
    await viewer.until('k.pieces === 2 && k.tick === given.tick', { tick });
    await viewer.page.getByText('The sheet went back to a saved state').waitFor();
    await viewer.screenshot('states');
    await row.locator('.icon').click();
    await row.waitFor({ state: 'detached' });
    await viewer.page.locator('#state-list-empty').waitFor();
    check(viewer.errors.length === 0, `console: ${viewer.errors.join('; ')}`);
    await viewer.page.close();
  });
}
