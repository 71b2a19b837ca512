import { Replay_State } from '../gen/kerf/v1/sheets_pb';
import type { Replay } from '../gen/kerf/v1/sheets_pb';
import type { NoticeKind } from '../tools/tool';

/** What to say of a sheet that has played a server's recording to where it goes no further. */
export function runEndText({ state, endTick, divergedTick }: Replay): [kind: NoticeKind, text: string] | undefined {
  if (state === Replay_State.DONE) {
    return ['success', `Played to its end at tick ${endTick}, bit for bit as recorded. Resume it to let the sheet run on its own`];
  }
  if (state !== Replay_State.DIVERGED) return undefined;
  const why = 'another build of the server recorded it, or the file was edited';
  return ['warning', `Played as recorded to tick ${divergedTick} of ${endTick}, and differently from there on: ${why}`];
}
