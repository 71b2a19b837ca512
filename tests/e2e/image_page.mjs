// A page that shows pictures of the server in place of the mesh: what its picture is, and what colours it has.
import { check } from './harness.mjs';

export function distance(one, other) {
  return Math.max(...one.map((value, i) => Math.abs(value - other[i])));
}

function pictureText(viewer) {
  return viewer.page.evaluate(() => document.querySelector('#picture').toDataURL());
}

/** True if this Chromium decodes VP8 itself. */
export function decodesVp8(page) {
  return page.evaluate(
    async () =>
      typeof VideoDecoder !== 'undefined' && (await VideoDecoder.isConfigSupported({ codec: 'vp8' })).supported === true,
  );
}

export async function enter(viewer) {
  await viewer.page.click('#image-mode');
  await viewer.until('k.picture?.connection === "live" && k.picture.isOfView');
}

/** Waits for the picture from where the camera is now. */
export function settle(viewer) {
  return viewer.until('k.picture.isOfView');
}

/** Does what changes the picture of a sheet that does not move, and waits until it has. */
export async function changes(viewer, act) {
  const before = await pictureText(viewer);
  await act();
  await viewer.page.waitForFunction((was) => document.querySelector('#picture').toDataURL() !== was, before);
}

/** Colours of the page once they are as wanted: a video still gets finer after the picture that showed a change. */
export async function coloursOnce(viewer, points, name, isSo, what) {
  for (let tries = 0; ; ++tries) {
    const colours = await viewer.colours(points, name);
    if (isSo(colours)) return;
    check(tries < 100, `${what}: ${colours.join(' and ')}`);
  }
}

/** Colours of the page without what lies over the picture. */
export async function bareColours(viewer, points, name) {
  const setCards = (visibility) =>
    viewer.page.evaluate((value) => {
      for (const card of document.querySelectorAll('.card')) card.style.visibility = value;
    }, visibility);
  await setCards('hidden');
  const colours = await viewer.colours(points, name);
  await setCards('');
  return colours;
}

/**
 * Checks that the sheet ends in the picture where the page's camera sees its sides: inside it looks like cloth, outside like
 * what is beside it.
 */
export async function isInPlace(viewer, name) {
  const sides = [
    [0, 0.5],
    [1, 0.5],
    [0.5, 0],
    [0.5, 1],
  ];
  const points = [];
  // Material points are placed in the view that was drawn last.
  await viewer.allDrawn();
  for (const [x, y] of sides) {
    const side = await viewer.at(x, y);
    const middle = await viewer.at(0.5, 0.5);
    // A twentieth of the sheet to each side of its border.
    for (const share of [0.9, 1.1]) {
      points.push({ x: middle.x + share * (side.x - middle.x), y: middle.y + share * (side.y - middle.y) });
    }
  }
  const colours = await bareColours(viewer, points, name);
  const lightest = Math.max(...colours.filter((_, i) => i % 2 === 0).flat());
  check(lightest > 140, `${name}: the cloth is in the dark: its lightest channel is ${lightest}`);
  sides.forEach((side, i) => {
    const [inside, outside] = [colours[2 * i], colours[2 * i + 1]];
    check(distance(inside, outside) > 25, `${name}: at ${side} the cloth is ${inside}, beside it is ${outside}`);
  });
}

export async function savedPng(viewer) {
  const downloading = viewer.page.waitForEvent('download');
  await viewer.page.keyboard.press('Control+s');
  await viewer.page.click('#save-png');
  const download = await downloading;
  const chunks = [];
  for await (const chunk of await download.createReadStream()) chunks.push(chunk);
  return { name: download.suggestedFilename(), png: Buffer.concat(chunks) };
}
