import { call } from '../api';
import { Replay_State, Sheet_RunState, SheetService } from '../gen/kerf/v1/sheets_pb';
import type { Sheet } from '../gen/kerf/v1/sheets_pb';
import { Newest } from '../newest';
import type { Viewer } from '../tools/tool';
import { confirmed } from './confirmation';
import { element, setText } from './dom';
import { runEndText } from './run_text';
import { SpeedControl } from './speed_control';

interface PauseWish {
  /** sheets/{sheet} */
  name: string;
  isPaused: boolean;
}

/** Runs a call that changes the sheet and is answered by it. */
type Command = (run: () => Promise<Sheet>) => Promise<void>;

/** Pause, step, reset and how fast it runs. */
export class SimulationControls {
  private readonly pauseButton = element<HTMLButtonElement>('pause');

  readonly speed: SpeedControl;
  // sheets/{sheet} that plays a recording.
  private playing: string | undefined;
  // Not answered yet.
  private wish: PauseWish | undefined;
  private readonly pauses = new Newest<boolean>(
    async (name, isPaused) => {
      const { pauseSheet, resumeSheet } = SheetService.method;
      await this.viewer.command(() => (isPaused ? call(pauseSheet, { name }) : call(resumeSheet, { name })));
    },
    async () => void (this.wish = undefined),
  );

  constructor(private readonly viewer: Viewer & { readonly numStreams: number; command: Command }) {
    this.speed = new SpeedControl(viewer);
  }

  private get isPaused(): boolean {
    return this.viewer.sheet?.runState === Sheet_RunState.PAUSED;
  }

  /** Shows the run state and the speed. */
  show(): void {
    const { sheet } = this.viewer;
    if (sheet) {
      this.speed.show(sheet);
      this.showRun(sheet);
    }
    const label = this.isPaused ? 'Resume' : 'Pause';
    setText(this.pauseButton.querySelector('span')!, label);
    this.pauseButton.querySelector('use')!.setAttribute('href', this.isPaused ? '#icon-play' : '#icon-pause');
  }

  // That a recording has been played is told once, to whoever saw it being played.
  private showRun({ name, replay }: Sheet): void {
    const end = replay && runEndText(replay);
    if (end && this.playing === name) this.viewer.notify(...end);
    this.playing = replay?.state === Replay_State.PLAYING ? name : undefined;
  }

  /** The other of what was asked for last: two quick presses are two changes, whatever has been answered. */
  togglePause(): void {
    const { sheetName: name } = this.viewer;
    const isPaused = this.wish?.name === name ? this.wish.isPaused : this.isPaused;
    this.wish = { name, isPaused: !isPaused };
    this.pauses.put(name, this.wish.isPaused);
  }

  /** One tick; a running sheet is paused first. */
  async step(): Promise<void> {
    const { sheetName: name } = this.viewer;
    await this.viewer.command(async () => {
      if (!this.isPaused) await call(SheetService.method.pauseSheet, { name });
      return call(SheetService.method.stepSheet, { name, ticks: 1 });
    });
  }

  /** Asks first where others watch the sheet. */
  async reset(): Promise<void> {
    const { sheetName: name } = this.viewer;
    const { getSheet, resetSheet } = SheetService.method;
    const sheet = await this.viewer.attempt(() => call(getSheet, { name }));
    if (!sheet) return;
    const others = sheet.viewers - this.viewer.numStreams;
    const question = `${others === 1 ? 'Somebody else watches' : `${others} others watch`} this sheet. Reset it for everybody?`;
    if (others > 0 && !(await confirmed(question, 'Reset'))) return;
    await this.viewer.command(() => call(resetSheet, { name }));
  }
}
