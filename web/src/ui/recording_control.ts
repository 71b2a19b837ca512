import { encodeHeader } from '../stream/recording_format';
import type { RecordingProgress } from '../stream/stream_recorder';
import type { App } from '../app';
import { element, setText } from './dom';
import { fileName, saveFile } from './download';
import { bytesText } from './statistics_text';

/** Of a recorded file, bytes. At 10,000 vertices and 60 frames a second some one and a half minutes. */
const kLimitBytes = 128 * 1024 * 1024;

/** Records the frames of the sheet that is shown, and saves them as a file when it is stopped or full. */
export class RecordingControl {
  private readonly chip = element<HTMLButtonElement>('recording');
  private sheetName = '';
  private isStopping = false;

  constructor(private readonly app: App) {
    this.chip.addEventListener('click', () => this.stop());
  }

  get isOn(): boolean {
    return !this.chip.hidden;
  }

  start(): void {
    const { app } = this;
    if (this.isOn) return;
    if (!app.watch || app.watch.state === 'ended' || !app.sheet || !app.surface) {
      app.notify('error', 'Nothing is shown that could be recorded');
      return;
    }
    this.sheetName = app.sheetName;
    this.isStopping = false;
    app.watch.record(encodeHeader(app.sheet), kLimitBytes);
    // A recording begins with everything.
    app.restartWatch(false);
    this.chip.hidden = false;
    this.show({ numFrames: 0, numBytes: 0, durationMs: 0, isFull: false });
  }

  /** The file comes by and by. */
  stop(): void {
    if (!this.isOn || this.isStopping) return;
    this.isStopping = true;
    this.app.watch?.stopRecording();
  }

  /** What was recorded is gone. */
  lose(): void {
    if (!this.isOn) return;
    this.chip.hidden = true;
    this.app.notify('error', 'The recording is lost');
  }

  /** @param parts  the file, once it is finished */
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
      this.app.notify('warning', 'Nothing was recorded: no frame came');
      return;
    }
    const tick = this.app.surface?.mirror.tick ?? 0;
    const saved = saveFile(parts, fileName(this.sheetName, tick, 'kerfstream'), 'application/octet-stream');
    const seconds = (durationMs / 1000).toFixed(1);
    const limit = isFull ? `; it ended there at the limit of ${bytesText(kLimitBytes)}` : '';
    this.app.notify(isFull ? 'warning' : 'success', `${saved}: ${numFrames} frames, ${seconds} s${limit}`);
  }
}
