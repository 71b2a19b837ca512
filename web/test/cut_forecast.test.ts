import { create } from '@bufbuild/protobuf';
import { afterEach, beforeEach, expect, test, vi } from 'vitest';
import { CutResultSchema } from '../src/gen/kerf/v1/cuts_pb';
import { CutForecast, forecastText } from '../src/tools/cut_forecast';

const kRequest = { parent: 'sheets/demo', cut: { widthM: 0.01 } };
const kSlower = create(CutResultSchema, { tickBeforeUs: 3000, tickAfterUs: 52_000, tickBudgetUs: 16_667 });

beforeEach(() => {
  vi.useFakeTimers();
  vi.stubGlobal('window', globalThis);
});
afterEach(() => {
  vi.useRealTimers();
  vi.unstubAllGlobals();
});

test('a cut that ends real time is warned of, with what it costs', () => {
  expect(forecastText(kSlower)).toBe('This cut slows the sheet to 32 % of its speed: a tick then takes 52 ms of the 17 ms available');
});

test('nothing is said of a cut after which ticks fit, or of a sheet that was behind before', () => {
  expect(forecastText(create(CutResultSchema, { ...kSlower, tickAfterUs: 16_000 }))).toBe('');
  expect(forecastText(create(CutResultSchema, { ...kSlower, tickBeforeUs: 20_000 }))).toBe('');
});

test('the server is asked once the drawing has settled, and cuts nothing', async () => {
  const changed = vi.fn();
  const tryCut = vi.fn(async () => kSlower);
  const forecast = new CutForecast(changed, tryCut);
  for (let i = 0; i < 5; ++i) {
    forecast.ask(() => kRequest);
    await vi.advanceTimersByTimeAsync(300);
  }
  expect(tryCut).not.toHaveBeenCalled();
  await vi.advanceTimersByTimeAsync(200);
  expect(tryCut.mock.calls).toEqual([[{ ...kRequest, validateOnly: true }]]);
  expect(forecast.warning).toContain('52 ms');
  expect(changed).toHaveBeenCalledTimes(1);
});

test('a drawing that is given up, and an answer that comes late, say nothing', async () => {
  let answer: (result: typeof kSlower) => void = () => undefined;
  const forecast = new CutForecast(vi.fn(), () => new Promise((settle) => (answer = settle)));
  forecast.ask(() => kRequest);
  forecast.ask(undefined);
  await vi.advanceTimersByTimeAsync(1000);
  forecast.ask(() => kRequest);
  await vi.advanceTimersByTimeAsync(500);
  forecast.ask(() => ({ ...kRequest, parent: 'sheets/other' }));
  answer(kSlower);
  await vi.advanceTimersByTimeAsync(0);
  expect(forecast.warning).toBe('');
});

test('one question is under way at a time, and the newest drawing is asked about after it', async () => {
  const answers: ((result: typeof kSlower) => void)[] = [];
  const tryCut = vi.fn((_: { parent?: string }) => new Promise<typeof kSlower>((settle) => answers.push(settle)));
  const forecast = new CutForecast(vi.fn(), tryCut);
  for (const parent of ['sheets/a', 'sheets/b', 'sheets/c']) {
    forecast.ask(() => ({ ...kRequest, parent }));
    await vi.advanceTimersByTimeAsync(1000);
  }
  expect(tryCut).toHaveBeenCalledTimes(1);
  answers[0](kSlower);
  await vi.advanceTimersByTimeAsync(1000);
  expect(forecast.warning).toBe('');
  expect(tryCut.mock.calls.map(([request]) => request.parent)).toEqual(['sheets/a', 'sheets/c']);
  answers[1](kSlower);
  await vi.advanceTimersByTimeAsync(0);
  expect(forecast.warning).toContain('52 ms');
});

test('a cut that the server refuses is not warned of', async () => {
  const forecast = new CutForecast(vi.fn(), () => Promise.reject(new Error('refused')));
  forecast.ask(() => kRequest);
  await vi.advanceTimersByTimeAsync(500);
  expect(forecast.warning).toBe('');
});

test('the same drawing is asked about again once it cuts something else, and has settled there', async () => {
  const changed = vi.fn();
  const tryCut = vi.fn(async () => kSlower);
  const forecast = new CutForecast(changed, tryCut);
  let parent = 'seen from the front';
  forecast.follow('front');
  forecast.ask(() => ({ ...kRequest, parent }));
  await vi.advanceTimersByTimeAsync(500);
  forecast.follow('front');
  await vi.advanceTimersByTimeAsync(500);
  expect(tryCut).toHaveBeenCalledTimes(1);
  expect([forecast.warning === '', changed.mock.calls.length]).toEqual([false, 1]);
  // The camera turns, and comes to rest.
  parent = 'seen from the side';
  for (const place of ['turned', 'turned more', 'side']) {
    forecast.follow(place);
    await vi.advanceTimersByTimeAsync(300);
  }
  // The warning was about another cut.
  expect([forecast.warning, changed.mock.calls.length]).toEqual(['', 2]);
  expect(tryCut).toHaveBeenCalledTimes(1);
  await vi.advanceTimersByTimeAsync(200);
  expect(tryCut.mock.calls.at(-1)).toEqual([{ ...kRequest, parent: 'seen from the side', validateOnly: true }]);
  expect([forecast.warning === '', changed.mock.calls.length]).toEqual([false, 3]);
});

test('a change while a question is under way is asked about after it, and where nothing is drawn not at all', async () => {
  const answers: ((result: typeof kSlower) => void)[] = [];
  const tryCut = vi.fn(() => new Promise<typeof kSlower>((settle) => answers.push(settle)));
  const forecast = new CutForecast(vi.fn(), tryCut);
  forecast.ask(() => kRequest);
  await vi.advanceTimersByTimeAsync(500);
  forecast.follow('cut by somebody else');
  await vi.advanceTimersByTimeAsync(1000);
  expect(tryCut).toHaveBeenCalledTimes(1);
  answers[0](kSlower);
  await vi.advanceTimersByTimeAsync(500);
  expect([tryCut.mock.calls.length, forecast.warning]).toEqual([2, '']);
  forecast.ask(undefined);
  forecast.follow('cut once more');
  answers[1](kSlower);
  await vi.advanceTimersByTimeAsync(1000);
  expect([tryCut.mock.calls.length, forecast.warning]).toEqual([2, '']);
});
