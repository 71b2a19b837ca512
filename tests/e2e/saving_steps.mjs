// Statistics, pictures, meshes and recordings of what the viewer shows.
import { readFile, writeFile } from 'node:fs/promises';
import { check, post, root } from './harness.mjs';
import { ViewerPage } from './viewer_page.mjs';

const kWide = { viewport: { width: 1280, height: 720 }, colorScheme: 'light' };

async function statistics(viewer) {
  check(await viewer.page.isHidden('#statistics'), 'the statistics are there before they are asked for');
  await viewer.page.keyboard.press('u');
  // Every line has a value once a few frames have come.
  await viewer.page.waitForFunction(() => {
    const values = [...document.querySelectorAll('#statistics dd:not(.plot)')].map((value) => value.textContent);
    return values.length === 17 && values.every((text) => text !== '' && text !== '–');
  });
  const shown = await viewer.page.evaluate(() =>
    Object.fromEntries(
      [...document.querySelectorAll('#statistics dl > div')].map((row) => [
        row.querySelector('dt').textContent,
        row.querySelector('dd').textContent,
      ]),
    ),
  );
  check(shown.vertices === (await viewer.read('k.numVertices')).toLocaleString('en'), `vertices: ${shown.vertices}`);
  check(/^[1-8]$/.test(shown['in flight']), `in flight: ${shown['in flight']}`);
  check(/^\d+(\.\d+)? [kM]?B\/s, \d+(\.\d+)? [kM]?B$/.test(shown.bytes), `bytes: ${shown.bytes}`);
  // A line needs two frames.
  await viewer.page.waitForFunction(() => {
    const plots = [...document.querySelectorAll('#statistics canvas')];
    const isDrawn = (canvas) =>
      canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data.some((value) => value !== 0);
    return plots.length === 3 && plots.every(isDrawn);
  });
  await viewer.screenshot('statistics');
  await viewer.page.click('#statistics-toggle');
  check(await viewer.page.isHidden('#statistics'), 'the statistics do not go');
}

/** The downloaded file that a choice of the menu ends in. */
async function save(viewer, item) {
  const downloading = viewer.page.waitForEvent('download');
  await viewer.page.keyboard.press('Control+s');
  await viewer.page.locator('#save-menu').waitFor();
  await viewer.page.click(`#${item}`);
  const download = await downloading;
  return { name: download.suggestedFilename(), bytes: await readFile(await download.path()) };
}

async function pictures(viewer) {
  for (const [item, scale, extension] of [
    ['save-png', 1, 'png'],
    ['save-png-2', 2, '2x.png'],
  ]) {
    const { name, bytes } = await save(viewer, item);
    check(name === `demo-${await viewer.read('k.tick')}.${extension}`, `the picture is called ${name}`);
    await viewer.notice(`Saved ${name}`);
    // The header of a PNG.
    const [width, height] = [bytes.readUInt32BE(16), bytes.readUInt32BE(20)];
    check(width === 1280 * scale && height === 720 * scale, `${width} x ${height} pixels`);
    const at = await viewer.at(0.5, 0.3);
    const [cloth, sky] = await viewer.coloursOf(bytes, [
      { x: scale * at.x, y: scale * at.y },
      { x: 3, y: 3 },
    ]);
    check(
      cloth.some((value, i) => Math.abs(value - sky[i]) > 20),
      `the cloth is ${cloth}, the sky ${sky}`,
    );
    // No button of the page is in it: where the tools are is sky.
    const [tools] = await viewer.coloursOf(bytes, [{ x: scale * 30, y: scale * 360 }]);
    check(tools.every((value, i) => Math.abs(value - sky[i]) < 45), `at the tools the picture is ${tools}`);
    await writeFile(`${root}/build/e2e/saved-${extension}`, bytes);
  }
}

// Colours without their numbers say nothing to whoever gets the picture.
async function legends(viewer) {
  await viewer.page.keyboard.press('x');
  await viewer.until('k.numStrains > 0');
  await viewer.page.locator('#strain-ticks li:last-child', { hasText: / %$/ }).waitFor();
  for (const [item, scale] of [
    ['save-png', 1],
    ['save-png-2', 2],
  ]) {
    const { name, bytes } = await save(viewer, item);
    // For a picture 720 pixels high.
    const places = [40, 138, 236].map((x) => ({ x: scale * x, y: scale * 673 }));
    const [least, none, most] = await viewer.coloursOf(bytes, places);
    const isGrey = Math.max(...none) - Math.min(...none) < 12;
    check(least[2] > least[0] + 100 && isGrey && most[0] > most[2] + 100, `${name}: the scale is ${least}, ${none}, ${most}`);
    await writeFile(`${root}/build/e2e/saved-strains-${scale}.png`, bytes);
  }
  await viewer.page.keyboard.press('x');
  await viewer.until('k.numStrains === 0');
}

async function meshes(viewer) {
  const { vertices, tick } = await viewer.read('({ vertices: k.numVertices, tick: k.tick })');
  const triangles = await viewer.read('k.numTriangles');
  const obj = await save(viewer, 'save-obj');
  check(obj.name === `demo-${tick}.obj`, `the mesh is called ${obj.name}`);
  const lines = obj.bytes.toString().split('\n');
  const count = (kind) => lines.filter((line) => line.startsWith(`${kind} `)).length;
  const counts = [count('v'), count('vt'), count('f')];
  check(counts.join() === [vertices, vertices, triangles].join(), `OBJ: v, vt, f: ${counts}`);

  const { bytes } = await save(viewer, 'save-glb');
  check(bytes.toString('latin1', 0, 4) === 'glTF' && bytes.readUInt32LE(4) === 2, 'no glTF 2');
  check(bytes.readUInt32LE(8) === bytes.length, 'the length in the header is not that of the file');
  const gltf = JSON.parse(bytes.toString('utf8', 20, 20 + bytes.readUInt32LE(12)));
  const [primitive] = gltf.meshes[0].primitives;
  check(gltf.accessors[primitive.indices].count === 3 * triangles, 'glTF: not all triangles');
  const positions = gltf.accessors[primitive.attributes.POSITION];
  check(positions.count === vertices && gltf.accessors[primitive.attributes.TEXCOORD_0], 'glTF: not all vertices');
  // Corner (0, 0) of the sheet is its vertex 0.
  const { x } = await viewer.read('k.toWorld(0, 0)');
  check(positions.min[0] <= x + 1e-5 && positions.max[0] > positions.min[0] + 0.3, `glTF: x in ${positions.min[0]}..`);
}

/** The server's recording of the sheet, which is paused; and how it was then. */
async function saveRun(viewer, url) {
  await viewer.page.keyboard.press(' ');
  await viewer.until('k.isPaused');
  await viewer.page.keyboard.press('Control+s');
  await viewer.page.locator('#save-run').waitFor();
  await viewer.screenshot('save-menu');
  await viewer.page.keyboard.press('Escape');
  const { name, bytes } = await save(viewer, 'save-run');
  const { tick, state_hash: hash } = await post(url, 'SheetService/GetSheet', { name: 'sheets/demo' });
  check(name === `demo-${tick}.rec`, `the recording is called ${name}`);
  await viewer.notice(`Saved ${name}`);
  await viewer.page.keyboard.press(' ');
  await viewer.until('!k.isPaused');
  return { bytes, tick, hash };
}

async function playRun(viewer, url, { bytes, tick, hash }) {
  await viewer.page.setInputFiles('#run-file', { name: 'Fall again.rec', mimeType: '', buffer: bytes });
  await viewer.untilDrawn('k.sheet === "sheets/fall-again" && k.connection === "live" && k.framesDrawn > 0');
  await viewer.notice(new RegExp(`fall-again plays Fall again.rec, ${tick} ticks: it takes no commands`));
  await viewer.page.focus('#canvas');
  await viewer.page.keyboard.press('>');
  await viewer.page.keyboard.press('>');
  await viewer.screenshot('run-played');
  await viewer.notice(/Played to its end at tick \d+, bit for bit as recorded/);
  const again = await post(url, 'SheetService/GetSheet', { name: 'sheets/fall-again' });
  check(again.tick === tick && again.state_hash === hash, `it ends with ${again.tick} ${again.state_hash}, not ${tick} ${hash}`);
}

// Files that are not recordings, and transfers that are cancelled.
async function refuseRuns(viewer, { bytes }) {
  const changed = Buffer.from(bytes);
  changed[changed.length >> 1] ^= 1;
  await viewer.drop('broken.rec', changed);
  await viewer.notice(/^broken.rec is not played: [^()]*$/);
  await viewer.throttleUploads(200_000);
  await viewer.drop('long.rec', Buffer.concat([bytes, Buffer.alloc(4 << 20)]));
  await viewer.page.locator('#transfer', { hasText: 'Sending long.rec' }).waitFor();
  await viewer.page.waitForFunction(() => document.getElementById('transfer-progress').value > 0.05);
  await viewer.screenshot('transfer');
  await viewer.drop('other.rec', bytes);
  await viewer.notice(/^other.rec is not played: another file is being transferred/);
  await viewer.page.click('#transfer-cancel');
  await viewer.notice(/^long.rec is not played: it was cancelled/);
  check(await viewer.page.isHidden('#transfer'), 'what was cancelled is still shown');
  await viewer.throttleUploads(-1);
  viewer.errors = viewer.errors.filter((error) => !/400/.test(error));
}

/** Records while the sheet is cut and falls; the file, and what the page showed at its end. */
async function record(viewer) {
  await viewer.page.keyboard.press('r');
  await viewer.until('k.pieces === 1 && k.numVertices === 2500');
  await viewer.page.keyboard.press('Control+s');
  await viewer.page.click('#save-recording');
  await viewer.until('k.isRecording');
  const begin = await viewer.read('k.tick');
  await viewer.until('k.tick > given.begin + 40', { begin });
  await viewer.screenshot('recording');
  await viewer.setHidden(true);
  const unseen = await viewer.read('k.tick');
  await viewer.until('k.tick > given.unseen + 40', { unseen });
  // A stream without acknowledgements stands still, until the server ends it after 10 s and it begins again.
  const after = await viewer.read('k.tick');
  check(after < unseen + 300, `a page that nobody sees got nothing between ticks ${unseen} and ${after}`);
  await viewer.setHidden(false);
  await viewer.choose('cut');
  await viewer.page.keyboard.press('5');
  await viewer.page.keyboard.press('o');
  await viewer.drag(await viewer.at(0.3, 0.35), await viewer.at(0.45, 0.35));
  await viewer.page.mouse.up();
  await viewer.page.keyboard.press('Enter');
  await viewer.until('k.pieces === 2');
  const cut = await viewer.read('k.tick');
  await viewer.until('k.tick > given.cut + 40', { cut });
  await viewer.choose('view');
  // It stands still when the recording ends: the last frame is known.
  await viewer.page.keyboard.press(' ');
  await viewer.until('k.isPaused');
  const { hash, tick } = await viewer.read('({ hash: k.meshHash, tick: k.tick })');
  const downloading = viewer.page.waitForEvent('download');
  await viewer.page.click('#recording');
  const download = await downloading;
  check(download.suggestedFilename() === `demo-${tick}.kerfstream`, `called ${download.suggestedFilename()}`);
  await viewer.notice(/Saved demo-\d+\.kerfstream \([\d.]+ [kM]B\): \d+ frames/);
  check(!(await viewer.read('k.isRecording')), 'it goes on recording');
  return { path: await download.path(), hash, tick };
}

async function replay(viewer, { path, hash, tick }) {
  const file = { name: 'fall.kerfstream', mimeType: '', buffer: await readFile(path) };
  await viewer.page.setInputFiles('#replay-file', file);
  await viewer.until('k.connection === "replay" && k.replay.isPlaying && k.replay.index >= 0');
  await viewer.until('k.replay.index > 2');
  await viewer.screenshot('replay');
  await viewer.page.selectOption('#replay-speed', '4');
  await viewer.until('!k.replay.isPlaying && k.replay.index === k.replay.numFrames - 1');
  const end = await viewer.read('({ tick: k.tick, pieces: k.pieces, hash: k.meshHash })');
  check(end.tick === tick && end.pieces === 2 && end.hash === hash, `it ends with ${JSON.stringify(end)}`);
  // Back to the beginning by the slider, before the cut; then step by step.
  await viewer.page.fill('#replay-position', '0');
  await viewer.until('k.replay.index === 0 && k.pieces === 1 && k.numVertices === 2500');
  const first = await viewer.read('k.tick');
  await viewer.page.focus('#canvas');
  await viewer.page.keyboard.press('.');
  await viewer.until('k.replay.index === 1 && k.tick > given.first', { first });
  await viewer.page.click('#replay-back');
  await viewer.until('k.replay.index === 0 && k.tick === given.first', { first });
  await viewer.page.click('#replay-toggle');
  await viewer.until('!k.replay.isPlaying && k.tick === given.tick', { tick });
  check((await viewer.read('k.meshHash')) === hash, 'played again it ends with another mesh');
}

async function looks(viewer) {
  const { drawn } = await viewer.read('({ drawn: k.framesDrawn })');
  await viewer.page.focus('#canvas');
  await viewer.page.keyboard.press('k');
  await viewer.until('k.isByPiece && k.framesDrawn > given.drawn', { drawn });
  const [disc, rest] = await viewer.colours([await viewer.at(0.3, 0.35), await viewer.at(0.75, 0.6)], 'replay-pieces');
  check(disc.some((value, i) => Math.abs(value - rest[i]) > 40), `the pieces are ${disc} and ${rest}`);
  await viewer.page.keyboard.press('k');
  await viewer.page.keyboard.press('x');
  await viewer.notice(/No strains were recorded here/);
  await viewer.page.locator('#strain-missing').waitFor();
  const [legend, bar] = [await viewer.page.locator('#strain-legend').boundingBox(), await viewer.page.locator('#replay').boundingBox()];
  check(legend.y + legend.height < bar.y, 'the bar of the recording lies over the scale');
  await viewer.screenshot('replay-strains');
  await viewer.page.keyboard.press('x');
}

/** The live page shows a recording of the same sheet and goes back, and the sheet is as it was. */
async function leavesLiveSheet(viewer, { path }, url) {
  const demo = { name: 'sheets/demo' };
  await viewer.page.click('[data-panel=physics]');
  await viewer.shows('#pin-count', '2 vertices held');
  const { asked, release } = await viewer.hold('SheetService/GetSheet');
  await post(url, 'InteractionService/SetSheetPins', { ...demo, setPins: { pins: [] } });
  await asked;
  await viewer.drop('again.kerfstream', await readFile(path));
  await viewer.until('k.connection === "replay" && k.replay.index > 0');
  check(await viewer.page.isHidden('#panel-physics'), 'the panel of the live sheet is still open');
  for (const key of ['m', 'j']) {
    await viewer.page.keyboard.press(key);
    check(!(await viewer.page.locator('.side-panel:visible').count()), `${key} opens a panel of the live sheet`);
  }
  await release();
  const drawing = '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 2 2"><circle cx="1" cy="1" r="1"/></svg>';
  await viewer.drop('sign.svg', Buffer.from(drawing));
  await viewer.notice(/A recording cannot be changed/);
  const { pinnedVertices } = await viewer.read('({ pinnedVertices: k.pinnedVertices })');
  check(pinnedVertices.length === 2, `the live sheet's pins, ${pinnedVertices}, are shown in the recording`);
  await viewer.page.click('#replay-close');
  await viewer.until('k.connection === "live" && k.replay === undefined && k.pinnedVertices.length === 0');
  await viewer.choose('cut');
  check(!(await viewer.page.textContent('#cut-prompt')).includes('sign.svg'), 'what was dropped then is laid now');
}

async function refusals(viewer) {
  await viewer.page.keyboard.press('c');
  await viewer.notice(/A recording cannot be changed/);
  check((await viewer.read('k.tool')) === 'view', 'a tool is chosen that has nothing to work on');
  const isInert = (id) => viewer.page.evaluate((query) => document.querySelector(query).inert, id);
  check((await isInert('#pause')) && (await isInert('[data-tool=cut]')), 'the live controls are not switched off');
  const refuse = async (buffer, why) => {
    await viewer.page.setInputFiles('#replay-file', { name: 'bad.kerfstream', mimeType: '', buffer });
    await viewer.notice(why);
  };
  await refuse(Buffer.from('not a recording at all'), /bad.kerfstream cannot be played: it does not begin with KERFSTRM/);
}

export function savingSteps(steps, browser, server) {
  let viewer;
  let recorded;
  steps.step('the statistics come and go, with a value and a plot for each line', async () => {
    viewer = await ViewerPage.open(browser, server.url, kWide);
    await viewer.untilDrawn('k.connection === "live" && k.framesDrawn > 5');
    await statistics(viewer);
  });
  steps.step('pictures of what is seen are saved, without what lies over it', async () => {
    await viewer.page.keyboard.press(' ');
    await viewer.until('k.isPaused');
    await pictures(viewer);
    await legends(viewer);
  });
  steps.step('the mesh that is shown is saved as OBJ and as glTF', async () => {
    await meshes(viewer);
    await viewer.page.keyboard.press(' ');
    await viewer.until('!k.isPaused');
  });
  steps.step('what the server recorded is saved, and played by it as a new sheet that ends the same', async () => {
    const run = await saveRun(viewer, server.url);
    await playRun(viewer, server.url, run);
    await refuseRuns(viewer, run);
    await viewer.pick('demo');
    await viewer.until('k.sheet === "sheets/demo" && k.connection === "live"');
  });
  steps.step('frames are recorded while the sheet is cut', async () => {
    recorded = await record(viewer);
  });
  steps.step('a recording is played, sought and stepped, and ends with the mesh that was live', () =>
    replay(viewer, recorded),
  );
  steps.step('its pieces have colours, and that it has no strains is said', () => looks(viewer));
  steps.step('a recording plays on without its server, and cannot be changed', async () => {
    await server.stop();
    await viewer.page.fill('#replay-position', '0');
    await viewer.until('k.replay.index === 0 && k.connection === "replay"');
    await refusals(viewer);
    await viewer.screenshot('replay-refused');
    await server.start();
  });
  steps.step('a recording that is dropped is played, and closing it goes back to the live sheet', async () => {
    await viewer.drop('dropped.kerfstream', await readFile(recorded.path));
    await viewer.until('k.connection === "replay" && k.replay.isPlaying');
    await viewer.page.click('#replay-close');
    await viewer.until('k.connection === "live" && k.replay === undefined && k.tick > 0');
    // Messages of the browser about the server that was away.
    viewer.errors = viewer.errors.filter((error) => !/ERR_CONNECTION_REFUSED|WebSocket/.test(error));
  });
  steps.step('while a recording is shown the live sheet and its settings are left alone', async () => {
    await leavesLiveSheet(viewer, recorded, server.url);
    check(viewer.errors.length === 0, `console: ${viewer.errors.join('; ')}`);
    await viewer.page.close();
  });
}
