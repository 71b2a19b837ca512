import { beforeEach, describe, expect, it } from 'vitest';
import type { Viewer } from '../src/tools/tool';
import { GravityControl } from '../src/ui/physics/gravity_control';
import { WindControl } from '../src/ui/physics/wind_control';
import { SpeedControl } from '../src/ui/speed_control';
import { fakePage } from './support/fake_page';
import type { FakeElement } from './support/fake_page';
import { HeldCalls } from './support/held_calls';

describe.each([
  ['gravity', 'gravity', 'input', GravityControl],
  ['wind', 'wind-speed', 'input', WindControl],
  ['speed', 'speed', 'change', SpeedControl],
])('%s', (_, id, event, Control) => {
  let server: HeldCalls;
  let input: FakeElement;
  let viewer: { sheetName: string; refreshes: number };

  beforeEach(() => {
    input = fakePage()(id);
    server = new HeldCalls();
    const uses = { attempt: (run: () => Promise<unknown>) => run(), refreshSheet: async () => (viewer.refreshes += 1) };
    viewer = { sheetName: 'sheets/a', refreshes: 0, ...uses };
    new Control(viewer as unknown as Viewer);
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
});
