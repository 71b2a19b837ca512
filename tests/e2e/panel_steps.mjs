// The list of cuts, links to a view, and what is read from the sheet, all on one page and one sheet that is paused.
import { readFile } from 'node:fs/promises';
import { kFlatScene } from './cutting_scenes.mjs';
import { check, post } from './harness.mjs';
import { ViewerPage } from './viewer_page.mjs';

const kSheet = 'sheets/panels';
const kYellow = [255, 210, 63];

export function panelSteps(steps, browser, { url }) {
  let viewer;

  steps.step('a cut in the list is shown on the sheet, and undone with all after it', async () => {
    const scene = { ...kFlatScene, grid: { columns: 11, rows: 11, widthM: 1, heightM: 1 } };
    await post(url, 'SheetService/CreateSheet', { sheetId: 'panels', scene, paused: true });
    const circle = (x) => ({ curve: { circle: { center: { x, y: 0.5 }, radiusM: 0.15 } } });
    await post(url, 'CutService/CreateCut', { parent: kSheet, cut: circle(0.25) });
    viewer = await ViewerPage.open(browser, `${url}/?sheet=panels`, { viewport: { width: 1000, height: 700 }, colorScheme: 'light' });
    const { page } = viewer;
    await viewer.untilDrawn('k.connection === "live" && k.isPaused && k.framesDrawn > 0');
    await page.keyboard.press('Shift+C');
    const rows = page.locator('#cut-list .open');
    await rows.filter({ hasText: /Cut 1/ }).waitFor();
    // One that is made while the list is open, on the picture.
    await viewer.choose('cut');
    await page.keyboard.press('i');
    await viewer.tap(0.55, 0.6);
    await viewer.tap(0.75, 0.75);
    await page.keyboard.press('Enter');
    await rows.filter({ hasText: /Cut 2.*through what was seen.*by you/ }).waitFor();
    check((await rows.count()) === 2, 'not two cuts');
    for (const index of [0, 1]) {
      await rows.nth(index).focus();
      check((await viewer.numPixels(kYellow, `cut-list-${index}`)) > 100, `the lips of row ${index} are not shown`);
    }
    await page.getByRole('button', { name: 'Undo cut 1 and the one after it' }).click();
    await page.click('#confirmation-yes');
    await viewer.notice(/^2 cuts undone: 1 piece/);
    await page.locator('#cut-list-empty').waitFor();
    check((await viewer.numPixels(kYellow, 'cut-list-undone')) === 0, 'lips that are gone are shown');
    await viewer.choose('view');
  });

  steps.step('a link opens the sheet from the same place and in the same colours', async () => {
    const { page } = viewer;
    await page.context().grantPermissions(['clipboard-read', 'clipboard-write']);
    await page.focus('#canvas');
    for (const key of ['ArrowLeft', 'ArrowLeft', 'Shift+ArrowUp', '+', 'w', 'k']) await page.keyboard.press(key);
    await viewer.allDrawn();
    const before = await viewer.at(0.3, 0.7);
    await page.keyboard.press('Shift+L');
    await viewer.notice(/^Link copied/);
    const link = await page.evaluate(() => navigator.clipboard.readText());
    await page.goto(`${link}&resolution=full`);
    await viewer.untilDrawn('k.connection === "live" && k.isPaused && k.framesDrawn > 0');
    const after = await viewer.at(0.3, 0.7);
    check(Math.hypot(after.x - before.x, after.y - before.y) < 1, `${JSON.stringify(before)} became ${JSON.stringify(after)}`);
    for (const id of ['wireframe', 'by-piece']) {
      check((await page.getAttribute(`#${id}`, 'aria-pressed')) === 'true', `${link} opens without ${id}`);
    }
    await page.keyboard.press('w');
    await page.keyboard.press('k');
  });

  steps.step('distances on the sheet are measured, and the axes turn the view', async () => {
    const { page } = viewer;
    await page.getByRole('button', { name: 'Look from +z' }).click();
    await viewer.allDrawn();
    const [origin, right, up] = [await viewer.at(0, 0), await viewer.at(1, 0), await viewer.at(0, 1)];
    check(Math.abs(right.y - origin.y) < 2 && right.x > origin.x, `x is not to the right: ${JSON.stringify({ origin, right })}`);
    check(up.y < origin.y, 'y is not up');
    await viewer.choose('measure');
    await viewer.tap(0.2, 0.4);
    await viewer.tap(0.6, 0.7);
    // The sheet is flat and undeformed; a point is known to a pixel.
    const isHalf = (text) => /^(49|50)(\.\d+)? cm$/.test(text);
    await page.waitForFunction(() => document.querySelector('#measure-space').textContent !== '');
    for (const id of ['space', 'sheet']) {
      const text = await page.textContent(`#measure-${id}`);
      check(isHalf(text), `${id}: ${text}`);
    }
    await viewer.shows('#measure-rest', '10,000 cm²');
    await viewer.picture('measured');
    await page.focus('#canvas');
    await page.keyboard.press('Escape');
    await viewer.shows('#measure-space', '');
    await page.keyboard.press('v');
    check(!(await page.isVisible('#measure-panel')), 'the numbers stay without the tool');
  });

  steps.step('energy and the place of a point are plotted while the sheet falls, and saved', async () => {
    const { page } = viewer;
    await page.keyboard.press('f');
    await page.keyboard.press('Shift+G');
    await page.click('#plot-add');
    await page.selectOption('#plot-quantity', 'position');
    await page.click('#plot-add');
    await viewer.shows('#plot-prompt', await page.evaluate(() => 'Click the point on the sheet'));
    await viewer.tap(0.3, 0.5);
    await page.locator('#plot-list canvas').nth(1).waitFor();
    await page.locator('#plot-list li li', { hasText: /^total / }).waitFor();
    await post(url, 'InteractionService/SetSheetGravity', { name: kSheet, setGravity: { gravityMps2: { z: -9.81 } } });
    await post(url, 'SheetService/StepSheet', { name: kSheet, ticks: 30 });
    // A fall from rest for half a second: y of the point stays, z is 1.2 m lower.
    await page.locator('#plot-list li li', { hasText: /^kinetic [\d.]+ J$/ }).waitFor();
    await page.locator('#plot-list > li').nth(1).locator('li', { hasText: /^z −/ }).waitFor();
    const place = await page.locator('#plot-list > li').nth(1).locator('li').allTextContents();
    check(/^x (29\d|30\d)(\.\d)? mm$/.test(place[0]), `the point is at ${place}`);
    await viewer.picture('plots');
    const downloaded = page.waitForEvent('download');
    await page.getByRole('button', { name: 'Save the values as CSV: Energy' }).click();
    const path = await (await downloaded).path();
    const [heading, ...rows] = (await readFile(path, 'utf8')).trim().split('\n');
    check(heading.startsWith('tick,time_s,energy.kinetic_J'), heading);
    check(rows.at(-1).startsWith('30,0.5,'), `the last of ${rows.length} rows is ${rows.at(-1)}`);
    await page.getByRole('button', { name: 'Remove the plot: Energy' }).click();
    check((await page.locator('#plot-list > li').count()) === 1, 'the plot stays');
    check(viewer.errors.length === 0, `console: ${viewer.errors.join('; ')}`);
    await page.close();
    await post(url, 'SheetService/DeleteSheet', { name: kSheet });
  });
}
