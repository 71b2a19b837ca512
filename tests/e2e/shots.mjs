// Pictures of the viewer's main states at three sizes, light and dark, for the eye; no test.
//   node tests/e2e/shots.mjs PATH/TO/kerfd [--only TEXT] [--size 390x844]...    into build/shots
// A picture is taken if TEXT is in its name, such as "cuts-1280x720-dark".
import { mkdirSync } from 'node:fs';
import { resolve } from 'node:path';
import { parseArgs } from 'node:util';
import { Server, launchChromium, post, root } from './harness.mjs';
import { ViewerPage } from './viewer_page.mjs';

const kSheet = 'sheets/shot';
const kScene = {
  grid: { columns: 40, rows: 40, widthM: 1, heightM: 1 },
  material: { preset: 'demo', youngsModulusPa: 1.5e5 },
  materials: [
    { region: { box: { min: { x: 0, y: 0.5 }, max: { x: 0.3, y: 1 } } }, material: { preset: 'denim' } },
    { region: { box: { min: { x: 0.3, y: 0.7 }, max: { x: 0.6, y: 1 } } }, material: { preset: 'wool' } },
    { region: { box: { min: { x: 0.8, y: 0 }, max: { x: 1, y: 0.6 } } }, material: { preset: 'rubber' } },
  ],
  fidelity: 'REAL_TIME',
  placement: { origin: { x: -0.5, y: -0.5, z: 0.8 }, xAxis: { x: 1 }, yAxis: { y: 1 } },
  pins: [{ edge: 'TOP_CORNERS' }],
  colliders: [
    { sphere: { center: { y: -0.05, z: 0.5 }, radiusM: 0.25 }, friction: 0.4 },
    { plane: { point: {}, normal: { z: 1 } }, friction: 0.5 },
  ],
};
const kCuts = [
  { bezier: { points: [{ x: 0.42, y: -0.05 }, { x: 0.62, y: 0.1 }, { x: 0.38, y: 0.24 }, { x: 0.55, y: 0.4 }] } },
  { circle: { center: { x: 0.12, y: 0.12 }, radiusM: 0.07 } },
];

const press = (...keys) => async ({ page }) => {
  await page.focus('#canvas');
  for (const key of keys) await page.keyboard.press(key);
};

// Steps before each picture, on a page with the still sheet.
const kStates = {
  rest: async () => {},
  cutting: async (viewer) => {
    await viewer.choose('cut');
    for (const [x, y] of [[0.15, 0.45], [0.3, 0.75], [0.55, 0.6], [0.7, 0.5]]) await viewer.tap(x, y);
  },
  cuts: async (viewer) => {
    await press('Shift+C')(viewer);
    await viewer.page.locator('#panel-cuts .open').last().hover();
  },
  help: press('?'),
  measure: async (viewer) => {
    await press('Shift+M')(viewer);
    await viewer.tap(0.2, 0.8);
    await viewer.tap(0.8, 0.75);
  },
  share: async ({ page }) => {
    await page.click('#save-open');
    await page.hover('#save-link');
  },
  link: press('Shift+L'),
  picture: async (viewer) => {
    await press('q')(viewer);
    await viewer.until('k.picture?.connection === "live" && k.picture.isOfView');
  },
  physics: press('m'),
  // Last, as it moves the sheet.
  plots: async (viewer) => {
    await press('Shift+G')(viewer);
    await viewer.page.selectOption('#plot-quantity', { index: 1 });
    await viewer.page.click('#plot-add');
    await post(viewer.url, 'SheetService/StepSheet', { name: kSheet, ticks: 30 });
  },
};

const kSizes = ['390x844', '1280x720', '1920x1080'];

const { values, positionals } = parseArgs({
  allowPositionals: true,
  options: { only: { type: 'string', default: '' }, size: { type: 'string', multiple: true, default: kSizes } },
});
mkdirSync(`${root}build/shots`, { recursive: true });
const server = new Server(resolve(positionals[0]), resolve(root, 'web/dist'));
await server.start();
const browser = await launchChromium(process.env.CHROMIUM ?? '/usr/bin/chromium');
try {
  await post(server.url, 'SheetService/CreateSheet', { sheetId: 'shot', scene: kScene, paused: true });
  await post(server.url, 'SheetService/StepSheet', { name: kSheet, ticks: 45 });
  for (const curve of kCuts) await post(server.url, 'CutService/CreateCut', { parent: kSheet, cut: { curve } });
  await post(server.url, 'SheetService/StepSheet', { name: kSheet, ticks: 30 });
  for (const size of values.size) {
    const [width, height] = size.split('x').map(Number);
    for (const colorScheme of ['light', 'dark']) {
      for (const [state, act] of Object.entries(kStates)) {
        const name = `${state}-${size}-${colorScheme}`;
        if (!name.includes(values.only)) continue;
        const isPhone = Math.min(width, height) < 500;
        const touch = { hasTouch: isPhone, isMobile: isPhone };
        const options = { viewport: { width, height }, colorScheme, reducedMotion: 'reduce', ...touch };
        const viewer = await ViewerPage.open(browser, `${server.url}/?sheet=shot`, options);
        viewer.url = server.url;
        await viewer.untilDrawn('k.connection === "live" && k.numVertices > 0');
        await act(viewer).catch((error) => console.log(`${name}: ${error.message}`));
        await viewer.allDrawn();
        await viewer.page.screenshot({ path: `${root}build/shots/${name}.png` });
        await viewer.page.close();
      }
    }
  }
} finally {
  await browser.close();
  await server.stop();
}
