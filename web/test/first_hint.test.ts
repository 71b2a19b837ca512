import { expect, test } from 'vitest';
import { FirstHint } from '../src/ui/first_hint';

function shown(kept: Map<string, string>, mayKeep = true) {
  const line = { hidden: false };
  let click = () => {};
  const close = { addEventListener: (_: string, listener: () => void) => void (click = listener) };
  const storage = () => {
    if (!mayKeep) throw new Error('SecurityError');
    return { getItem: (key: string) => kept.get(key) ?? null, setItem: (key: string, value: string) => void kept.set(key, value) };
  };
  const hint = new FirstHint(line as HTMLElement, close as unknown as HTMLElement, storage);
  return { line, hint, click: () => click() };
}

test('a first visit has the hint, until it is closed, and a second one has not', () => {
  const kept = new Map<string, string>();
  const first = shown(kept);
  expect(first.line.hidden).toBe(false);
  first.click();
  expect(first.line.hidden).toBe(true);
  expect(shown(kept).line.hidden).toBe(true);
});

test('whoever tries a tool has read it', () => {
  const kept = new Map<string, string>();
  shown(kept).hint.close();
  expect(shown(kept).line.hidden).toBe(true);
});

test('where nothing may be kept it is there each time, and can be closed', () => {
  const { line, hint } = shown(new Map(), false);
  expect(line.hidden).toBe(false);
  hint.close();
  expect(line.hidden).toBe(true);
});
