import { call } from '../api';
import { Replay_State, Sheet_RunState, SheetService } from '../gen/kerf/v1/sheets_pb';
import type { Sheet } from '../gen/kerf/v1/sheets_pb';
import { Newest } from '../newest';
import type { Reporter } from '../notifier';
import type { OpenSheet, ShownState } from '../sheet/open_sheet';
import { element, setText } from './dom';
import { agreedForEveryone } from './for_everyone';
import { runEndText } from './run_text';
import { SpeedControl } from './speed_control';

interface PauseWish {
  /** sheets/{sheet} */
  name: string;
  isPaused: boolean;
}

/** The live sheet, for calls that change it. */
interface CommandedSheet extends OpenSheet {
  /** Runs a call whose answer has the sheet's settings. */
  command(run: () => Promise<Sheet>): Promise<void>;
}

/** Pause, step, reset and speed. */
export class SimulationControls {
  private readonly pauseButton = element<HTMLButtonElement>('pause');

  readonly speed: SpeedControl;
  // sheets/{sheet} last shown playing a recording; undefined: none.
  private playing: string | undefined;
  // The last request to pause or resume, until it is answered.
  private wish: PauseWish | undefined;
  private readonly pauses = new Newest<boolean>(
    async (name, isPaused) => {
      const { pauseSheet, resumeSheet } = SheetService.method;
      await this.live.command(() => (isPaused ? call(pauseSheet, { name }) : call(resumeSheet, { name })));
    },
    async () => void (this.wish = undefined),
  );

  /** @param numStreams  returns the number of streams of the sheet to this page */
  constructor(
    private readonly live: CommandedSheet,
    private readonly shown: Pick<ShownState, 'sheet'>,
    private readonly reporter: Reporter,
    private readonly numStreams: () => number,
  ) {
    this.speed = new SpeedControl(live, reporter);
  }

  private get isPaused(): boolean {
    return this.shown.sheet?.runState === Sheet_RunState.PAUSED;
  }

  /** Shows the run state and the speed. */
  show(): void {
    const { sheet } = this.shown;
    if (sheet) {
      this.speed.show(sheet);
      this.showRun(sheet);
    }
    const label = this.isPaused ? 'Resume' : 'Pause';
    setText(this.pauseButton.querySelector('span')!, label);
    this.pauseButton.querySelector('use')!.setAttribute('href', this.isPaused ? '#icon-play' : '#icon-pause');
  }

  // Reports once that a recording has been played, if this page has shown it playing.
  private showRun({ name, replay }: Sheet): void {
    const end = replay && runEndText(replay);
    if (end && this.playing === name) this.reporter.notify(...end);
    this.playing = replay?.state === Replay_State.PLAYING ? name : undefined;
  }

  /** Requests the opposite of the last request, so that two quick presses are two changes, even before an answer. */
  togglePause(): void {
    const { sheetName: name } = this.live;
    const isPaused = this.wish?.name === name ? this.wish.isPaused : this.isPaused;
    this.wish = { name, isPaused: !isPaused };
    this.pauses.put(name, this.wish.isPaused);
  }

  /** Steps one tick; a running sheet is paused first. */
  async step(): Promise<void> {
    const { sheetName: name } = this.live;
    await this.live.command(async () => {
      if (!this.isPaused) await call(SheetService.method.pauseSheet, { name });
      return call(SheetService.method.stepSheet, { name, ticks: 1 });
    });
  }

  /** Resets the sheet; asks for confirmation if others watch it. */
  async reset(): Promise<void> {
    const { sheetName: name } = this.live;
    if (!(await agreedForEveryone(name, this.numStreams(), 'Reset', this.reporter))) return;
    await this.live.command(() => call(SheetService.method.resetSheet, { name }));
  }
}
