// Sheets, panels, keys and themes of the viewer, in Chromium against a real kerfd: each control by clicks and by keys,
// what it does looked up on the server. Waits are for conditions, never for time.
import { accessSteps } from './access_steps.mjs';
import { Steps, check, launchChromium, startKerfd } from './harness.mjs';
import { physicsSteps } from './physics_steps.mjs';
import { sheetSteps } from './sheet_steps.mjs';
import { ViewerPage } from './viewer_page.mjs';

const [kerfdPath, web, chromiumPath] = process.argv.slice(2);
const kerfd = await startKerfd(kerfdPath, web);
const browser = await launchChromium(chromiumPath);
const steps = new Steps(
  async (name) => {
    for (const page of browser.contexts().flatMap((context) => context.pages())) {
      const path = `build/e2e/failed-${name.replaceAll(/\W+/g, '-')}.png`;
      await page.screenshot({ path }).catch((error) => console.log(String(error)));
    }
  },
  () => check(ViewerPage.exceptions.length === 0, `uncaught on a page: ${ViewerPage.exceptions.join('; ')}`),
);

// PARTS=physics,access runs these alone.
const parts = { sheets: sheetSteps, physics: physicsSteps, access: accessSteps };
for (const name of process.env.PARTS?.split(',') ?? Object.keys(parts)) await parts[name](steps, browser, kerfd.url);

await browser.close();
const status = await kerfd.stop();
await steps.step('kerfd ends with status 0', async () => check(status === 0, `it ended with ${status}`));
console.log(`${steps.passed} passed, ${steps.failed} failed`);
process.exitCode = steps.failed === 0 ? 0 : 1;
