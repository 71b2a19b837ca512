import type { Sheet } from '../gen/kerf/v1/sheets_pb';
import type { Notifier } from '../notifier';
import { Replay } from '../stream/replay';
import type { FrameCopy, SheetCopy } from '../stream/sheet_copy';
import { startWorker } from '../stream/workers';
import { element, setLiveControls, setText } from './dom';
import { bytesText } from './statistics_text';

/** Largest file that is read into memory, bytes: four times the limit of this viewer's recordings. */
const kMaxFileBytes = 512 * 1024 * 1024;

// Keys that change the live sheet, and do nothing while a recording is shown.
const kLiveChords = new Set(['R', '<', '>', '0', 'Ctrl+Z', 'Ctrl+Shift+Z', 'Ctrl+Y', 'M', 'J']);

export function isRecordingFile(file: File): boolean {
  return file.name.toLowerCase().endsWith('.kerfstream');
}

export interface ReplayEvents {
  /** Called when a recording has been read and checked, and is shown from now on. */
  onOpened(sheet: Sheet): void;
  onFrame(copy: SheetCopy, frame: FrameCopy): void;
  /** Called when the recording, or the reading of its file, has ended: the live sheet is to be shown again. */
  onClosed(): void;
}

/** Plays a recording in place of the live sheet: files, buttons, slider, keys. Needs no server. */
export class ReplayBar {
  private readonly bar = element('replay');
  private readonly input = element<HTMLInputElement>('replay-file');
  private readonly toggleButton = element<HTMLButtonElement>('replay-toggle');
  private readonly position = element<HTMLInputElement>('replay-position');
  private readonly speed = element<HTMLSelectElement>('replay-speed');
  private readonly progress = element<HTMLProgressElement>('replay-progress');
  private worker: Worker | undefined;
  private replay: Replay | undefined;
  // The file that is read or shown; results for files chosen before are ignored.
  private file: File | undefined;

  constructor(
    private readonly events: ReplayEvents,
    private readonly notices: Notifier,
  ) {
    this.input.addEventListener('change', () => {
      const file = this.input.files?.[0];
      // Clears the input, so that the same file can be chosen again.
      this.input.value = '';
      if (file) void this.open(file);
    });
    const on = (id: string, act: () => void) => element(id).addEventListener('click', act);
    on('replay-toggle', () => this.replay?.togglePlaying());
    on('replay-back', () => this.replay?.step(-1));
    on('replay-forward', () => this.replay?.step(1));
    on('replay-close', () => this.close());
    this.position.addEventListener('input', () => this.replay?.seek(this.position.valueAsNumber));
    this.speed.addEventListener('change', () => this.setSpeed());
  }

  /** True if a recording is shown. */
  get isOpen(): boolean {
    return this.replay?.sheet !== undefined;
  }

  /** sheets/{sheet} that was recorded; undefined if no recording is shown */
  get sheetName(): string | undefined {
    return this.replay?.sheet?.name;
  }

  get playing(): Replay | undefined {
    return this.isOpen ? this.replay : undefined;
  }

  /** True if a recording is shown or being read. */
  get hasFile(): boolean {
    return this.file !== undefined;
  }

  /** Lets the user choose a file. */
  choose(): void {
    this.input.click();
  }

  async open(file: File): Promise<void> {
    const refuse = (why: string) => this.notices.notify('error', `${file.name} cannot be played: ${why}`);
    if (file.size > kMaxFileBytes) {
      return refuse(`it has ${bytesText(file.size)}; at most ${bytesText(kMaxFileBytes)} can be read`);
    }
    const fail = (why: string) => {
      refuse(why);
      this.close();
    };
    // Closes the recording before, so that keys and controls never act on a sheet that is not shown.
    this.close();
    this.file = file;
    this.bar.hidden = false;
    this.setChecking(true);
    const bytes = await file.arrayBuffer().catch(() => undefined);
    if (file !== this.file) return;
    if (!bytes) return fail('the browser cannot read it');
    this.worker = startWorker('replay', (why) => fail(`the player failed: ${why}`));
    const events = {
      onProgress: (share: number) => (this.progress.value = share),
      onOpened: (replay: Replay) => this.opened(replay, file.name),
      onFrame: (copy: SheetCopy, frame: FrameCopy) => this.events.onFrame(copy, frame),
      onFailed: fail,
    };
    this.replay = new Replay(this.worker, events, bytes);
  }

  private close(): void {
    this.leave();
    this.events.onClosed();
  }

  /** Ends the recording that is shown or being read, if any. */
  leave(): void {
    this.worker?.terminate();
    this.worker = undefined;
    this.replay = undefined;
    this.file = undefined;
    this.bar.hidden = true;
    setLiveControls(true);
  }

  /**
   * Handles a chord (see chordOf). True if it has a meaning for a replay, or would change the live sheet, which is not
   * shown.
   */
  key(chord: string): boolean {
    const { file, playing } = this;
    if (file && chord === 'Escape') this.close();
    else if (!playing) return false;
    else if (chord === 'Space') playing.togglePlaying();
    else if (chord === '.') playing.step(1);
    else if (chord === ',') playing.step(-1);
    else return kLiveChords.has(chord);
    return true;
  }

  /** Plays up to `nowMs`; true if the shown frame changes. */
  advance(nowMs: number): boolean {
    const { replay } = this;
    if (!replay || !this.isOpen) return false;
    const hasChanged = replay.advance(nowMs);
    const isDragged = document.activeElement === this.position;
    if (!isDragged || replay.isPlaying) this.position.valueAsNumber = replay.atMs;
    setText(element('replay-time'), `${seconds(replay.atMs)} / ${seconds(replay.durationMs)} s`);
    setText(element('replay-tick'), `tick ${replay.tick.toLocaleString('en')}`);
    const [icon, label] = replay.isPlaying ? ['#icon-pause', 'Pause'] : ['#icon-play', 'Play'];
    const use = this.toggleButton.querySelector('use')!;
    if (use.getAttribute('href') !== icon) use.setAttribute('href', icon);
    setText(this.toggleButton.querySelector('span')!, label);
    return hasChanged;
  }

  private opened(replay: Replay, fileName: string): void {
    this.setChecking(false);
    this.position.max = String(replay.durationMs);
    this.setSpeed();
    this.events.onOpened(replay.sheet!);
    replay.togglePlaying();
    if (replay.numTornBytes > 0) {
      const bytes = bytesText(replay.numTornBytes);
      this.notices.notify('warning', `${fileName} is incomplete: ${bytes} after the last complete frame were skipped`);
    }
  }

  private setSpeed(): void {
    if (this.replay) this.replay.speed = Number(this.speed.value);
  }

  private setChecking(isOn: boolean): void {
    this.progress.value = 0;
    this.progress.hidden = !isOn;
    element('replay-controls').hidden = isOn;
  }
}

function seconds(ms: number): string {
  return (ms / 1000).toFixed(2);
}
