import { create } from '@bufbuild/protobuf';
import { beforeEach, describe, expect, it } from 'vitest';
import { SheetSchema } from '../src/gen/kerf/v1/sheets_pb';
import type { Sheet } from '../src/gen/kerf/v1/sheets_pb';
import { NewestAnswer } from '../src/newest_answer';
import type { Viewer } from '../src/tools/tool';
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
  let viewer: { sheetName: string; refreshes: number; refreshSheet: () => Promise<unknown> };
  let control: { show(sheet: Sheet): void };

  beforeEach(() => {
    input = fakePage()(id);
    server = new HeldCalls();
    const uses = { attempt: (run: () => Promise<unknown>) => run(), refreshSheet: async () => (viewer.refreshes += 1) };
    viewer = { sheetName: 'sheets/a', refreshes: 0, ...uses };
    control = new Control(viewer as unknown as Viewer);
  });

  it('of a sheet goes to that sheet, though another one is shown by then', async () => {
    input.enter('0.5', event);
    input.enter('0.25', event);
    viewer.sheetName = 'sheets/b';
    input.enter('2', event);
    for (let left = 3; left > 0; --left) await server.answer();
    expect(server.calls.map(({ request }) => request.name)).toEqual(['sheets/a', 'sheets/a', 'sheets/b']);
    expect(viewer.refreshes).toBe(1);
  });

  it('stays as it was set, though an answer from before the change comes after it', async () => {
    const tell: ((sheet: Sheet) => void)[] = [];
    const answers = new NewestAnswer<Sheet>(
      () => new Promise((resolve) => tell.push(resolve)),
      (sheet) => control.show(sheet),
    );
    viewer.refreshSheet = () => answers.refresh();
    void answers.fetch();
    input.enter('0.5', event);
    await server.answer();
    await told(tell[0], 2);
    expect(Number(input.value)).toBe(0.5);
    await told(tell[1], 4);
    expect(Number(input.value)).toBe(4);
  });
});
