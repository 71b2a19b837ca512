// What the viewer does with streams, in Chromium against a real kerfd: slow and lost connections, statistics, recordings,
// pictures that are saved, pictures that the server draws. Waits are for conditions, never for time; nothing about speed is asserted.
import { connectionSteps } from './connection_steps.mjs';
import { Steps, check, launchChromium, startKerfd } from './harness.mjs';
import { imageSteps } from './image_steps.mjs';
import { savingSteps } from './saving_steps.mjs';
import { ViewerPage } from './viewer_page.mjs';

const [kerfdPath, web, chromiumPath] = process.argv.slice(2);
const start = (http, options) => startKerfd(kerfdPath, web, http, options);
let kerfd = await start();
const browser = await launchChromium(chromiumPath);
const steps = new Steps(
  () => ViewerPage.screenshotAll(browser, 'failed-streams'),
  () => check(ViewerPage.exceptions.length === 0, `uncaught on a page: ${ViewerPage.exceptions.join('; ')}`),
);

// PARTS=images,connection runs these alone.
const parts = { saving: savingSteps, connection: connectionSteps, images: imageSteps };
for (const name of process.env.PARTS?.split(',') ?? Object.keys(parts)) {
  kerfd = await parts[name](steps, browser, kerfd, start);
}

await browser.close();
const status = await kerfd.stop();
await steps.step('kerfd ends with status 0', async () => check(status === 0, `it ended with ${status}`));
console.log(`${steps.passed} passed, ${steps.failed} failed`);
process.exitCode = steps.failed === 0 ? 0 : 1;
