import { create } from '@bufbuild/protobuf';
import { describe, expect, it } from 'vitest';
import { Replay_State, ReplaySchema } from '../src/gen/kerf/v1/sheets_pb';
import { runEndText } from '../src/ui/run_text';

describe('runEndText', () => {
  const at = (state: Replay_State) => runEndText(create(ReplaySchema, { state, endTick: 600n, divergedTick: 64n }));

  it('tells of an end, and whether it came out as recorded', () => {
    expect(at(Replay_State.PLAYING)).toBeUndefined();
    expect(at(Replay_State.DONE)).toEqual(['success', expect.stringContaining('tick 600, bit for bit')]);
    expect(at(Replay_State.DIVERGED)).toEqual(['warning', expect.stringContaining('tick 64 of 600')]);
  });
});
