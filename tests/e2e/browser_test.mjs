// The viewer in one Chromium against a real kerfd. Waits are for conditions, never for time; nothing about speed is
// asserted.
import { accessSteps } from './access_steps.mjs';
import { connectionSteps } from './connection_steps.mjs';
import { cuttingSteps } from './cutting_steps.mjs';
import { Server, check, kPatienceMs, launchChromium, post } from './harness.mjs';
import { imageSteps } from './image_steps.mjs';
import { layoutSteps } from './layout_steps.mjs';
import { loadingSteps } from './loading_steps.mjs';
import { loginSteps } from './login_steps.mjs';
import { lookSteps } from './look_steps.mjs';
import { panelSteps } from './panel_steps.mjs';
import { peopleSteps } from './people_steps.mjs';
import { physicsSteps } from './physics_steps.mjs';
import { savingSteps } from './saving_steps.mjs';
import { sheetSteps } from './sheet_steps.mjs';
import { Group, Runner, within } from './steps.mjs';
import { stripSteps } from './strip_steps.mjs';
import { ViewerPage } from './viewer_page.mjs';
import { viewerSteps } from './viewer_steps.mjs';

// Groups in their order; an outer name runs all groups in it.
const kGroups = {
  viewer: { watching: viewerSteps, looks: lookSteps, cutting: cuttingSteps, strips: stripSteps },
  controls: { sheets: sheetSteps, physics: physicsSteps, panels: panelSteps, access: accessSteps, login: loginSteps, people: peopleSteps, layout: layoutSteps },
  streams: { saving: savingSteps, connection: connectionSteps, images: imageSteps, loading: loadingSteps },
};
// Groups that need the demo sheet from its beginning. For others it is paused, so that it is neither computed nor drawn.
const kFresh = ['watching', 'sheets', 'saving', 'connection', 'images', 'loading'];

const [kerfdPath, web, chromiumPath, again, ...args] = process.argv.slice(2);
const names = [];
let only = '';
while (args.length > 0) {
  const arg = args.shift();
  if (arg === '--only') only = args.shift() ?? '';
  else names.push(arg);
}
const known = Object.entries(kGroups).flatMap(([set, groups]) => [set, ...Object.keys(groups)]);
const unknown = names.find((name) => !known.includes(name));
if (unknown !== undefined) {
  console.error(`tests/e2e/run: no group '${unknown}'; there are ${known.join(' ')}`);
  process.exit(2);
}

const server = new Server(kerfdPath, web);
await server.start();
const browser = await launchChromium(chromiumPath);
let isFresh = true;

const groups = [];
for (const [set, members] of Object.entries(kGroups)) {
  for (const [name, declare] of Object.entries(members)) {
    const group = new Group(name);
    declare(group, browser, server);
    const isNamed = names.length === 0 || names.includes(set) || names.includes(name);
    if (isNamed && group.isAbout(only)) groups.push(group);
  }
}
if (groups.length === 0) {
  console.error(`tests/e2e/run: no step and no group has '${only}' in its name`);
} else {
  const last = new Group('end');
  last.step('kerfd ends with status 0', () => server.stop());
  groups.push(last);
}

async function standStill() {
  await post(server.url, 'SheetService/PauseSheet', { name: 'sheets/demo' });
  const { sheets } = await post(server.url, 'SheetService/ListSheets', {});
  for (const { name } of sheets) {
    if (name !== 'sheets/demo') await post(server.url, 'SheetService/DeleteSheet', { name });
  }
}

async function closePages() {
  const closed = Promise.all(browser.contexts().map((context) => context.close()));
  await within(kPatienceMs, closed, 'the pages of a group close');
}

const runner = new Runner({
  prepare: async ({ name }) => {
    if (name === 'end') return;
    if (kFresh.includes(name) && !isFresh) await server.startAgain();
    else if (!kFresh.includes(name)) await standStill();
    isFresh = false;
  },
  afterStep: () => check(ViewerPage.exceptions.length === 0, `uncaught on a page: ${ViewerPage.exceptions.join('; ')}`),
  onFailure: async ({ name: group }, step) => {
    const pictures = await ViewerPage.screenshotAll(browser, `failed-${group}-${step.replaceAll(/\W+/g, '-').slice(0, 60)}`);
    return [...pictures.map((path) => `  picture: ${path}`), `  again:   ${again} ${group}`];
  },
  afterGroup: async (_, hasPassed) => {
    ViewerPage.exceptions.length = 0;
    await closePages();
    if (hasPassed) return;
    // A fresh server keeps what a failed group has left from the next one.
    await server.stop().catch((error) => console.log(error.message));
    await server.start();
    isFresh = true;
  },
});
await runner.run(groups);
await server.stop();
// Chromium has hung on its way out: that is no fault of the viewer, and leaving kills what is left of it.
await within(kPatienceMs, browser.close(), 'Chromium closes').catch((error) => console.log(error.message));
process.exit(runner.failed === 0 && runner.passed > 0 ? 0 : 1);
