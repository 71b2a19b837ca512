// The panel of all sheets: what it lists, new sheets of every kind, refusals at their fields, deletion.
import { rm, truncate, writeFile } from 'node:fs/promises';
import { check, post, root } from './harness.mjs';
import { ViewerPage } from './viewer_page.mjs';

const kWide = { viewport: { width: 1280, height: 720 }, colorScheme: 'light' };
const kPhone = { viewport: { width: 390, height: 844 }, colorScheme: 'dark', hasTouch: true, isMobile: true };
const kSquareObj = 'v 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\nf 1 2 3\nf 1 3 4\n';
// One closed line on a page of 200 x 100.
const kOutline = `<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 200 100"><ellipse cx="100" cy="50" rx="90" ry="45"/></svg>`;
// Three holes: two subpaths, one of them after a close, and a shape by reference.
const kPlate = `<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 200 100"><defs><circle id="hole" r="15"/></defs>
<path d="m10 10h180v80h-180zm20 20v40h20v-40z m60 10a10 10 0 1 0 20 0 10 10 0 1 0-20 0z"/><use href="#hole" x="150" y="50"/></svg>`;

const kPly = `ply
format ascii 1.0
element vertex 4
property float x
property float y
property float z
element face 2
property list uchar int vertex_indices
end_header
0 0 1
1 0 1
1 1 1
0 1 1
3 0 1 2
3 0 2 3
`;

// A square of n x n vertices.
function gridObj(n) {
  const at = (i) => (i / (n - 1)).toFixed(12);
  const lines = [];
  for (let y = 0; y < n; ++y) for (let x = 0; x < n; ++x) lines.push(`v ${at(x)} ${at(y)} 1.000000000000`);
  for (let y = 1; y < n; ++y) {
    for (let x = 1; x < n; ++x) {
      const corner = (y - 1) * n + x;
      lines.push(`f ${corner} ${corner + 1} ${corner + n + 1}`, `f ${corner} ${corner + n + 1} ${corner + n}`);
    }
  }
  return `${lines.join('\n')}\n`;
}

export function sheetSteps(steps, browser, { url }) {
  const sheet = (name) => post(url, 'SheetService/GetSheet', { name: `sheets/${name}` });
  const names = async () => (await post(url, 'SheetService/ListSheets', {})).sheets.map(({ name }) => name);
  let viewer;
  const row = (name) => viewer.page.locator('#sheet-list li', { hasText: name });
  const openForm = async () => {
    await viewer.page.click('#new-sheet-open');
    await viewer.page.locator('#new-sheet[open]').waitFor();
    // The materials are the server's.
    await viewer.page.locator('#new-material option').nth(1).waitFor({ state: 'attached' });
  };
  const shape = (value) => viewer.page.locator(`#new-sheet [name=shape][value=${value}]`).check({ force: true });
  const create = async (name, numVertices) => {
    await viewer.page.fill('#new-id', name);
    await viewer.page.click('#new-create');
    await viewer.until('k.sheet === given.sheet && k.connection === "live"', { sheet: `sheets/${name}` });
    check(new URL(viewer.page.url()).searchParams.get('sheet') === name, `the address is ${viewer.page.url()}`);
    const made = await sheet(name);
    check(!numVertices || made.num_vertices === numVertices, `${name} has ${made.num_vertices} vertices`);
    return made;
  };

  steps.step('the panel of sheets lists what the server has, and follows it', async () => {
    viewer = await ViewerPage.open(browser, url, kWide);
    await viewer.untilDrawn('k.connection === "live" && k.framesDrawn > 0');
    await viewer.page.click('[data-panel=sheets]');
    await row('demo').waitFor();
    check((await row('demo').locator('[aria-current]').count()) === 1, 'the sheet that is watched is not marked');
    await post(url, 'SheetService/PauseSheet', { name: 'sheets/demo' });
    await row('demo').locator('.badge', { hasText: 'paused' }).waitFor();
    check(/2,\d+ vertices, 1 piece$/.test(await row('demo').locator('small').textContent()), 'its size is not told');
    await viewer.until('k.isPaused');
    await viewer.screenshot('sheets');
  });

  steps.step('a grid is made as asked for', async () => {
    await openForm();
    await viewer.page.fill('#new-columns', '12');
    await viewer.page.fill('#new-rows', '8');
    await viewer.page.fill('#new-width', '0.6');
    await viewer.page.selectOption('#new-material', 'silk');
    const facts = await viewer.page.textContent('#new-material-facts');
    check(facts.includes('80 MPa along, 60 MPa across') && facts.includes('50.4 g/m²'), `silk is told as ${facts}`);
    await viewer.page.selectOption('#new-pins', { label: 'left edge' });
    await viewer.page.check('#new-paused');
    await viewer.screenshot('new-sheet');
    const made = await create('flag', 96);
    check(made.run_state === 'PAUSED' && made.pinned_vertices.length === 8, JSON.stringify(made));
    check(made.scene.material.density_kgpm3 === 420, `not silk: ${JSON.stringify(made.scene.material)}`);
    check(await viewer.page.evaluate(() => document.activeElement.id === 'canvas'), 'the keyboard is not the sheet’s');
    await viewer.until('k.framesDrawn > 0 && k.numVertices === 96 && k.toWorld(0.6, 1)');
    const width = await viewer.read('k.toWorld(0.6, 1).x - k.toWorld(0, 1).x');
    check(Math.abs(width - 0.6) < 1e-3, `it is ${width} m wide`);
    check(made.scene.colliders.length === 2, 'floor and ball are not there');
    await row('flag').waitFor();
  });

  steps.step('a stiff sheet is softened where real time is chosen, and Physics says by how much', async () => {
    const kExact = '1';
    const fidelity = () => viewer.page.inputValue('#new-fidelity');
    const line = viewer.page.locator('#material-softening');
    check((await sheet('flag')).scene.fidelity === 'EXACT', 'a sheet is not exact unless asked for');
    await openForm();
    check((await fidelity()) === kExact, 'the form does not begin with exact');
    await viewer.page.fill('#new-columns', '50');
    await viewer.page.fill('#new-rows', '50');
    await viewer.page.fill('#new-width', '1');
    await viewer.page.selectOption('#new-material', 'wool');
    await viewer.page.selectOption('#new-fidelity', { label: 'real time' });
    await viewer.page.check('#new-paused');
    await viewer.screenshot('new-sheet-real-time');
    const { scene, softening } = await create('stiff', 2500);
    check(scene.fidelity === 'REAL_TIME' && softening.factor > 1, JSON.stringify({ ...softening, fidelity: scene.fidelity }));
    await viewer.page.click('[data-panel=physics]');
    await line.filter({ hasText: ` ${softening.factor} times softer` }).waitFor();
    const [, millimetres] = /: ([\d.]+) mm /.exec(await line.textContent());
    const error = 1e3 * softening.expected_error_m;
    check(Math.abs(millimetres / error - 1) < 0.05, `the error is told as ${millimetres} mm, and is ${error} mm`);
    await line.scrollIntoViewIfNeeded();
    await viewer.screenshot('softened');
    // The line is gone where the material needs no softening.
    await viewer.page.selectOption('#material-preset', 'demo');
    await line.waitFor({ state: 'hidden' });
    await viewer.page.selectOption('#material-preset', 'wool');
    await line.waitFor();
    await viewer.pick('flag');
    await line.waitFor({ state: 'hidden' });
    await viewer.page.click('[data-panel=sheets]');
    // The form keeps its choices for the next sheet.
    await openForm();
    check((await fidelity()) !== kExact, 'the choice is forgotten');
    await viewer.page.selectOption('#new-fidelity', kExact);
    await viewer.page.click('#new-sheet [data-close]');
  });

  steps.step('OBJ, PLY and an outline become sheets', async () => {
    for (const [name, text] of [
      ['square.obj', kSquareObj],
      ['square2.ply', kPly],
    ]) {
      await openForm();
      await shape('file');
      await viewer.page.setInputFiles('#new-file', { name, mimeType: 'text/plain', buffer: Buffer.from(text) });
      await viewer.page.locator('#new-file-name', { hasText: name }).waitFor();
      await create(name.split('.')[0], 4);
    }
    await openForm();
    await shape('outline');
    const drawing = { name: 'egg.svg', mimeType: 'image/svg+xml', buffer: Buffer.from(kOutline) };
    await viewer.page.setInputFiles('#new-outline', drawing);
    await viewer.page.locator('#new-outline-name', { hasText: 'egg.svg' }).waitFor();
    await create('egg');
    // 0.9 m wide on a page of 1 m.
    await viewer.until('k.framesDrawn > 0 && k.numVertices > 100');
    const reach = await viewer.read('[k.toWorld(0.06, -0.25), k.toWorld(0.94, -0.25)].map((at) => at.x)');
    check(Math.abs(reach[1] - reach[0] - 0.88) < 0.02, `the outline spans ${reach}`);
  });

  steps.step('lines inside a border become holes, scaled and placed with it', async () => {
    await openForm();
    await shape('outline');
    const drawing = { name: 'plate.svg', mimeType: 'image/svg+xml', buffer: Buffer.from(kPlate) };
    await viewer.page.setInputFiles('#new-outline', drawing);
    await viewer.page.locator('#new-outline-name', { hasText: 'plate.svg, with 3 holes' }).waitFor();
    await create('plate');
    await viewer.until('k.framesDrawn > 0 && k.numVertices > 100');
    // The page is 1 m wide: in the holes there is no material, between them there is.
    await viewer.until('k.pieceAt(0.3, -0.25) !== undefined');
    const places = '[[0.2, -0.25], [0.5, -0.2], [0.75, -0.25], [0.3, -0.25], [0.62, -0.3]]';
    const isThere = await viewer.read(`${places}.map((at) => k.pieceAt(...at) !== undefined)`);
    check(isThere.join() === 'false,false,false,true,true', `material in three holes and at two places: ${isThere}`);
    await viewer.screenshot('plate');
  });

  steps.step('a mesh larger than a request is sent, and how far it is is told', async () => {
    const text = gridObj(161);
    check(text.length > 2 << 20, `the mesh has only ${text.length} bytes`);
    await openForm();
    await shape('file');
    await viewer.page.setInputFiles('#new-file', { name: 'fine.obj', mimeType: 'text/plain', buffer: Buffer.from(text) });
    await viewer.page.locator('#new-file-name', { hasText: /^fine.obj, 2\.\d MiB$/ }).waitFor();
    await viewer.page.check('#new-paused');
    await viewer.throttleUploads(300_000);
    await viewer.page.click('#new-create');
    await viewer.page.waitForFunction(() => {
      const { hidden, value } = document.getElementById('new-progress');
      return !hidden && value > 0.1 && value < 1;
    });
    await viewer.screenshot('new-sheet-sent');
    await viewer.throttleUploads(-1);
    await viewer.until('k.sheet === "sheets/fine" && k.numVertices === 161 * 161');
    check((await sheet('fine')).run_state === 'PAUSED', 'what else was asked for is lost');
  });

  steps.step('a mesh that is dropped on the sheet opens the form with it', async () => {
    await viewer.drop('Dropped Cloth.obj', Buffer.from(kSquareObj));
    await viewer.page.locator('#new-sheet[open] #new-file-name', { hasText: 'Dropped Cloth.obj' }).waitFor();
    check((await viewer.page.inputValue('#new-id')) === 'dropped-cloth', 'its name is not taken from the file');
    await viewer.page.click('#new-create');
    await viewer.until('k.sheet === "sheets/dropped-cloth"');
  });

  steps.step('refusals stand at their fields, and what was typed stays', async () => {
    await openForm();
    const refusal = async (field, pattern) => {
      await viewer.page.click('#new-create');
      await viewer.page.locator(`#new-${field}-error`, { hasText: pattern }).waitFor();
      check((await viewer.page.getAttribute(`#new-${field}`, 'aria-invalid')) === 'true', `${field} is not marked`);
    };
    await shape('grid');
    await viewer.page.fill('#new-columns', '2000');
    await viewer.page.fill('#new-width', '-1');
    await refusal('columns', /^Columns: give a whole number from 2 to 1,000$/);
    await refusal('width', /^Width: give a length above 0 m, at most 10,000 m$/);
    await viewer.screenshot('new-sheet-refused');
    await viewer.page.fill('#new-columns', '');
    await refusal('columns', /^Columns: give a whole number/);
    await viewer.page.fill('#new-columns', '20');
    check(await viewer.page.isHidden('#new-columns-error'), 'a refusal stays though the field was changed');
    await viewer.page.fill('#new-width', '1');
    await viewer.page.fill('#new-id', 'demo');
    await refusal('id', /^A sheet named demo already exists$/);
    // A name is marked as it is typed.
    await viewer.page.fill('#new-id', 'Not An Id');
    await viewer.page.locator('#new-id-error', { hasText: /^Name: use small letters, .*, such as not-an-id$/ }).waitFor();
    await shape('file');
    await refusal('file', /Choose an OBJ/);
    const file = async (name, buffer) => viewer.page.setInputFiles('#new-file', { name, mimeType: 'text/plain', buffer });
    await file('notes.txt', Buffer.from('x'));
    await viewer.page.locator('#new-file-error', { hasText: 'notes.txt is not an OBJ, PLY or SVG file' }).waitFor();
    check((await viewer.page.inputValue('#new-id')) === '', 'a bad name outlives a new file');
    await viewer.page.fill('#new-id', 'broken');
    await file('broken.obj', Buffer.from('v 0 0 nonsense\n'));
    await refusal('file', /^Line 1/);
    await file('empty.obj', Buffer.alloc(0));
    await refusal('file', /empty.obj is empty/);
    // By its path: what is handed over as bytes may have 50 MB.
    const huge = `${root}/build/e2e/huge.obj`;
    await writeFile(huge, '');
    await truncate(huge, 70 << 20);
    await viewer.page.setInputFiles('#new-file', huge);
    await refusal('file', /has 70 MiB.*at most 64 MiB/);
    await rm(huge);
    check((await viewer.page.inputValue('#new-id')) === 'broken', 'what was typed is gone');
    const outlineFile = (name, text) =>
      viewer.page.setInputFiles('#new-outline', { name, mimeType: 'image/svg+xml', buffer: Buffer.from(text) });
    await shape('outline');
    await outlineFile('unsized.svg', '<svg xmlns="http://www.w3.org/2000/svg"><circle r="4"/></svg>');
    await viewer.page.locator('#new-outline-error', { hasText: 'does not say how large its page is' }).waitFor();
    check(await viewer.page.evaluate(() => document.activeElement.id === 'new-outline'), 'the focus is not at the refused file');
    await outlineFile('apart.svg', kPlate.replace('x="150"', 'x="250"'));
    await viewer.page.locator('#new-outline-error', { hasText: /apart.svg has lines outside .* or remove them/ }).waitFor();
    await outlineFile('torn.svg', '<svg viewBox="0 0 9 9"><circ');
    await viewer.page.locator('#new-outline-error', { hasText: /^torn.svg is broken: .* in line 1$/ }).waitFor();
    await viewer.page.fill('#new-id', '');
    await viewer.page.keyboard.type('typed-on');
    check((await viewer.page.inputValue('#new-id')) === 'typed-on', 'a refused file takes the keyboard from who types');
    await viewer.page.click('#new-sheet [data-close]');
    // The browser writes refusals to the console.
    viewer.errors = viewer.errors.filter((error) => !/40[09]/.test(error));
  });

  steps.step('a sheet is deleted when that is confirmed, and another one is shown', async () => {
    await row('egg').locator('.icon').click();
    await viewer.page.locator('#confirmation[open]', { hasText: 'egg' }).waitFor();
    await viewer.screenshot('confirmation');
    await viewer.page.keyboard.press('Escape');
    check((await names()).includes('sheets/egg'), 'a deletion that was not confirmed was done');
    await row('egg').locator('.icon').click();
    await viewer.page.click('#confirmation-yes');
    await row('egg').waitFor({ state: 'detached' });
    check(!(await names()).includes('sheets/egg'), 'the server still has it');
    const rest = (await names()).filter((name) => name !== 'sheets/dropped-cloth');
    await row('dropped-cloth').locator('.icon').click();
    await viewer.page.click('#confirmation-yes');
    await viewer.until('k.sheet === given.sheet && k.connection === "live"', { sheet: rest[0] });
    check(viewer.errors.length === 0, `console: ${viewer.errors.join('; ')}`);
    await viewer.page.close();
  });

  steps.step('on a phone, in the dark, a sheet is made and opened from another', async () => {
    viewer = await ViewerPage.open(browser, `${url}/?sheet=demo`, kPhone);
    await viewer.untilDrawn('k.connection === "live" && k.framesDrawn > 0');
    await viewer.page.tap('[data-panel=sheets]');
    await row('demo').waitFor();
    await viewer.screenshot('phone-sheets');
    await openForm();
    await viewer.page.fill('#new-columns', '10');
    await viewer.page.fill('#new-rows', '10');
    await viewer.screenshot('phone-new-sheet');
    await create('phone', 100);
    await row('flag').locator('.open').tap();
    await viewer.until('k.sheet === "sheets/flag" && k.connection === "live"');
    check(viewer.errors.length === 0, `console: ${viewer.errors.join('; ')}`);
    await viewer.page.close();
  });
}
