import { create } from '@bufbuild/protobuf';
import { beforeEach, describe, expect, it } from 'vitest';
import { SheetSchema } from '../src/gen/kerf/v1/sheets_pb';
import type { Sheet } from '../src/gen/kerf/v1/sheets_pb';
import { NewestAnswer } from '../src/newest_answer';
import type { Reporter } from '../src/notifier';
import { GravityControl } from '../src/ui/physics/gravity_control';
import { WindControl } from '../src/ui/physics/wind_control';
import { SpeedControl } from '../src/ui/speed_control';
import { fakePage } from './support/fake_page';
import type { FakeElement } from './support/fake_page';
import { HeldCalls } from './support/held_calls';

/** Answers with this value of each setting, and waits until that has been taken. */
function told(tell: (sheet: Sheet) => void, value: number): Promise<unknown> {
  const scene = { gravityMps2: { z: -value }, wind: { velocityMps: { x: value } } };
  tell(create(SheetSchema, { speed: value, scene }));
  return new Promise((resolve) => setTimeout(resolve));
}

describe.each([
  ['gravity', 'gravity', 'input', GravityControl],
  ['wind', 'wind-speed', 'input', WindControl],
  ['speed', 'speed', 'change', SpeedControl],
])('%s', (_, id, event, Control) => {
  let server: HeldCalls;
  let input: FakeElement;
  let live: { sheetName: string; refresh: () => Promise<void> };
  let numRefreshes: number;
  let control: { show(sheet: Sheet): void };

  beforeEach(() => {
    input = fakePage()(id);
    server = new HeldCalls();
    numRefreshes = 0;
    live = { sheetName: 'sheets/a', refresh: async () => void (numRefreshes += 1) };
    const reporter: Reporter = { attempt: (run) => run(), notify: () => {} };
    control = new Control(live, reporter);
  });

  it('of a sheet goes to that sheet, though another one is shown by then', async () => {
    input.enter('0.5', event);
    input.enter('0.25', event);
    live.sheetName = 'sheets/b';
    input.enter('2', event);
    for (let left = 3; left > 0; --left) await server.answer();
    expect(server.calls.map(({ request }) => request.name)).toEqual(['sheets/a', 'sheets/a', 'sheets/b']);
    expect(numRefreshes).toBe(1);
  });

  it('stays as it was set, though an answer from before the change comes after it', async () => {
    const tell: ((sheet: Sheet) => void)[] = [];
    const answers = new NewestAnswer<Sheet>(
      () => new Promise((resolve) => tell.push(resolve)),
      (sheet) => control.show(sheet),
    );
    live.refresh = async () => void (await answers.refresh());
    void answers.fetch();
    input.enter('0.5', event);
    await server.answer();
    await told(tell[0], 2);
    expect(Number(input.value)).toBe(0.5);
    await told(tell[1], 4);
    expect(Number(input.value)).toBe(4);
  });
});
