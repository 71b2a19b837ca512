import { expect, test, vi } from 'vitest';
import { SlowSheet } from '../src/ui/slow_sheet';

const kSlow = { realTimeFactor: 0.4, speed: 1, paused: false, sleeping: false };
const kFast = { ...kSlow, realTimeFactor: 1 };

function slowSheet(text = 'A tick takes 40 ms of the 16.7 ms available') {
  const notify = vi.fn();
  const advice = vi.fn(async () => text);
  return { sheet: new SlowSheet(notify, advice), notify, advice };
}

test('a sheet that falls behind is told of once, with the advice of the server', async () => {
  const { sheet, notify } = slowSheet();
  for (const ms of [0, 1000, 2900]) await sheet.saw('sheets/a', kSlow, ms);
  expect(notify).not.toHaveBeenCalled();
  for (const ms of [3100, 4000, 60_000]) await sheet.saw('sheets/a', kSlow, ms);
  expect(notify.mock.calls).toEqual([['warning', 'A tick takes 40 ms of the 16.7 ms available']]);
});

test('it is told of again after it has kept pace for as long', async () => {
  const { sheet, notify } = slowSheet();
  for (const ms of [0, 3100]) await sheet.saw('sheets/a', kSlow, ms);
  for (const ms of [3200, 4000]) await sheet.saw('sheets/a', kFast, ms); // for a moment only
  for (const ms of [4100, 7200]) await sheet.saw('sheets/a', kSlow, ms);
  expect(notify).toHaveBeenCalledTimes(1);
  for (const ms of [7300, 10_400]) await sheet.saw('sheets/a', kFast, ms);
  for (const ms of [10_500, 13_600]) await sheet.saw('sheets/a', kSlow, ms);
  expect(notify).toHaveBeenCalledTimes(2);
});

test('another sheet is timed by itself', async () => {
  const { sheet, notify } = slowSheet();
  for (const ms of [0, 2900]) await sheet.saw('sheets/a', kSlow, ms);
  await sheet.saw('sheets/b', kSlow, 3100);
  expect(notify).not.toHaveBeenCalled();
  await sheet.saw('sheets/b', kSlow, 6200);
  expect(notify).toHaveBeenCalledTimes(1);
});

test('nothing is said where only the machine is busy, in slow motion, and of a sheet at rest', async () => {
  const busy = slowSheet('');
  for (const ms of [0, 3100]) await busy.sheet.saw('sheets/a', kSlow, ms);
  expect(busy.advice).toHaveBeenCalledTimes(1);
  expect(busy.notify).not.toHaveBeenCalled();
  const { sheet, advice } = slowSheet();
  for (const ms of [0, 3100]) await sheet.saw('sheets/a', { ...kSlow, speed: 0.25 }, ms);
  for (const ms of [4000, 8000]) await sheet.saw('sheets/a', { ...kSlow, sleeping: true }, ms);
  expect(advice).not.toHaveBeenCalled();
});
