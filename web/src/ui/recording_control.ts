import type { Notifier } from '../notifier';
import type { OpenSheet, ShownState } from '../sheet/open_sheet';
import { encodeHeader } from '../stream/recording_format';
import type { RemoteWatch } from '../stream/remote_watch';
import type { RecordingProgress } from '../stream/stream_recorder';
import { element, setText } from './dom';
import { fileName, saveFile } from './download';
import { bytesText } from './statistics_text';

/** Largest file, bytes: about one and a half minutes of 10,000 vertices at 60 frames per second. */
const kLimitBytes = 128 * 1024 * 1024;

/** The live sheet, whose stream is recorded. */
export interface RecordedSheet extends Pick<OpenSheet, 'sheetName'> {
  readonly watch: Pick<RemoteWatch, 'state' | 'record' | 'stopRecording'> | undefined;
  /** Starts another stream of the same sheet, which begins with all triangles. */
  restart(goesOn: false): void;
}

/** Records the frames of the live sheet, and saves them as a file when the recording is stopped or full. */
export class RecordingControl {
  private readonly chip = element<HTMLButtonElement>('recording');
  private sheetName = '';
  private isStopping = false;

  constructor(
    private readonly live: RecordedSheet,
    private readonly shown: ShownState,
    private readonly notices: Notifier,
  ) {
    this.chip.addEventListener('click', () => this.stop());
  }

  get isOn(): boolean {
    return !this.chip.hidden;
  }

  start(): void {
    if (this.isOn) return;
    const { watch, sheetName } = this.live;
    const { sheet, surface } = this.shown;
    if (!watch || watch.state === 'ended' || !sheet || !surface) {
      this.notices.notify('error', 'There is nothing to record');
      return;
    }
    this.sheetName = sheetName;
    this.isStopping = false;
    watch.record(encodeHeader(sheet), kLimitBytes);
    // Starts a new stream, because a recording must begin with all triangles.
    this.live.restart(false);
    this.chip.hidden = false;
    this.show({ numFrames: 0, numBytes: 0, durationMs: 0, isFull: false });
  }

  /** Ends the recording; its file arrives later. */
  stop(): void {
    if (!this.isOn || this.isStopping) return;
    this.isStopping = true;
    this.live.watch?.stopRecording();
  }

  /** Call it when the recorded frames are lost. */
  lose(): void {
    if (!this.isOn) return;
    this.chip.hidden = true;
    this.notices.notify('error', 'The recording is lost');
  }

  /** @param parts  content of the file once the recording is finished, else undefined */
  took(progress: RecordingProgress, parts: ArrayBuffer[] | undefined): void {
    if (parts) {
      this.chip.hidden = true;
      this.save(progress, parts);
      return;
    }
    this.show(progress);
    if (progress.isFull) this.stop();
  }

  private show({ durationMs, numBytes }: RecordingProgress): void {
    setText(element('recording-text'), `${(durationMs / 1000).toFixed(0)} s, ${bytesText(numBytes)}`);
  }

  private save({ numFrames, durationMs, isFull }: RecordingProgress, parts: ArrayBuffer[]): void {
    if (numFrames === 0) {
      this.notices.notify('warning', 'Nothing was recorded: no frame arrived');
      return;
    }
    const tick = this.shown.surface?.mirror.tick ?? 0;
    const saved = saveFile(parts, fileName(this.sheetName, tick, 'kerfstream'), 'application/octet-stream');
    const seconds = (durationMs / 1000).toFixed(1);
    const limit = isFull ? `; it ended at the limit of ${bytesText(kLimitBytes)}` : '';
    this.notices.notify(isFull ? 'warning' : 'success', `${saved}: ${numFrames} frames, ${seconds} s${limit}`);
  }
}
