import { Replay_State } from '../gen/kerf/v1/sheets_pb';
import type { Replay } from '../gen/kerf/v1/sheets_pb';
import type { FrameStats } from '../gen/kerf/v1/stream_pb';
import type { NoticeKind } from '../notifier';
import { speedOf } from './speeds';

/**
 * Returns a notice about a sheet that has played a server's recording to its end, or as far as possible; undefined
 * before.
 */
export function runEndText({ state, endTick, divergedTick }: Replay): [kind: NoticeKind, text: string] | undefined {
  if (state === Replay_State.DONE) {
    return ['success', `Played to its end at tick ${endTick}, bit for bit as recorded. Resume it to let the sheet run on its own`];
  }
  if (state !== Replay_State.DIVERGED) return undefined;
  const why = 'another build of the server recorded it, or the file was edited';
  return ['warning', `Played as recorded to tick ${divergedTick} of ${endTick}, then differently: ${why}`];
}

/** Returns the reason why the sheet does not move; undefined if it moves or nothing is known of it. */
export function stillText(stats: Pick<FrameStats, 'paused' | 'sleeping'> | undefined): string | undefined {
  if (stats?.paused) return 'paused';
  return stats?.sleeping ? 'at rest' : undefined;
}

export function isStill(stats: Pick<FrameStats, 'paused' | 'sleeping'> | undefined): boolean {
  return stillText(stats) !== undefined;
}

/** True if the sheet is slower than its set speed, which in slow motion is below real time. */
export function isBehind(
  stats: Pick<FrameStats, 'paused' | 'sleeping' | 'realTimeFactor' | 'speed'> | undefined,
): boolean {
  return stats !== undefined && !isStill(stats) && stats.realTimeFactor < 0.95 * speedOf(stats);
}

/** Text for the age of a frame that is up to date because the sheet does not move. */
export const kCurrent = 'current';
