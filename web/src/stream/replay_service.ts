import { FrameCopier } from './frame_copier';
import { decodeRecording } from './recording_format';
import type { Recording } from './recording_format';
import type { FromReplay, ToReplay } from './replay_messages';
import { ReplayPlayer } from './replay_player';
import type { Port } from './watch_messages';

// A recording is checked in pieces of about this duration, between which the worker receives messages.
const kPieceMs = 50;

/** The worker's side of a replay: checks the whole file once, then sends any frame that the page requests. */
export class ReplayService {
  private player: ReplayPlayer | undefined;
  private readonly copier = new FrameCopier();
  private shownEpoch: string | undefined;

  constructor(private readonly page: Port<FromReplay, ToReplay>) {
    page.onmessage = ({ data }) => void this.receive(data).catch((error: Error) => this.fail(error));
  }

  private async receive(message: ToReplay): Promise<void> {
    if (message.kind === 'open') await this.open(new Uint8Array(message.file));
    else if (message.kind === 'seek') this.show(message.index);
    else this.copier.spare.put(message.buffers);
  }

  private async open(file: Uint8Array): Promise<void> {
    const recording = decodeRecording(file);
    const player = new ReplayPlayer(recording);
    let pieceEndMs = performance.now() + kPieceMs;
    for (let index = 0; index < player.numFrames; ++index) {
      player.seek(index);
      if (performance.now() < pieceEndMs) continue;
      this.page.postMessage({ kind: 'progress', share: (index + 1) / player.numFrames });
      await new Promise((resolve) => setTimeout(resolve));
      pieceEndMs = performance.now() + kPieceMs;
    }
    this.player = player;
    this.page.postMessage({ kind: 'opened', ...described(recording, player) });
  }

  private show(index: number): void {
    if (!this.player) return;
    const startedMs = performance.now();
    const { mirror, numBytes, isKeyframe } = this.player.seek(index);
    const isFirst = mirror.epoch !== this.shownEpoch;
    this.shownEpoch = mirror.epoch;
    const decodeMs = performance.now() - startedMs;
    const delivery = { numBytes, isKeyframe, numUnacknowledged: 0, decodeMs };
    const { frame, buffers } = this.copier.copy(mirror, delivery, isFirst);
    this.page.postMessage({ kind: 'frame', frame, index, isFirst }, buffers);
  }

  private fail(error: Error): void {
    this.page.postMessage({ kind: 'failed', message: error.message });
  }
}

function described({ sheet, messages, numTornBytes }: Recording, { ticks }: ReplayPlayer) {
  return { sheet, timesMs: Float64Array.from(messages, ({ atMs }) => atMs), ticks: ticks.slice(), numTornBytes };
}
