import { call } from '../api';
import { InteractionService } from '../gen/kerf/v1/interaction_pb';
import { Sheet_RunState, SheetService } from '../gen/kerf/v1/sheets_pb';
import type { Sheet } from '../gen/kerf/v1/sheets_pb';
import type { Viewer } from '../tools/tool';
import { element, setText } from './dom';

// kerf.v1.Scene.gravity_mps2 when the scene gives none.
const kDefaultGravityMps2 = 9.81;

/** Downward acceleration of the sheet's scene, metres per second squared. */
function downwardGravity(sheet: Sheet): number {
  const gravity = sheet.scene?.gravityMps2;
  return gravity ? -gravity.z : kDefaultGravityMps2;
}

/** Pause, step, reset and gravity. */
export class SimulationControls {
  private readonly pauseButton = element<HTMLButtonElement>('pause');
  private readonly gravity = element<HTMLInputElement>('gravity');
  private readonly gravityValue = element('gravity-value');
  private isSendingGravity = false;
  private wantedGravity: number | undefined;

  constructor(private readonly viewer: Viewer & { setSheet(sheet: Sheet): void }) {
    this.pauseButton.addEventListener('click', () => void this.togglePause());
    element('step').addEventListener('click', () => void this.step());
    element('reset').addEventListener('click', () => void this.reset());
    this.gravity.addEventListener('input', () => {
      this.showGravity(this.gravity.valueAsNumber);
      this.wantedGravity = this.gravity.valueAsNumber;
      void this.sendGravity();
    });
  }

  private get isPaused(): boolean {
    return this.viewer.sheet?.runState === Sheet_RunState.PAUSED;
  }

  /** Shows the settings in force. */
  show(sheet: Sheet): void {
    const label = this.isPaused ? 'Resume' : 'Pause';
    setText(this.pauseButton.querySelector('span')!, label);
    this.pauseButton.querySelector('use')!.setAttribute('href', this.isPaused ? '#icon-play' : '#icon-pause');
    if (this.isSendingGravity) return;
    this.gravity.value = String(downwardGravity(sheet));
    this.showGravity(downwardGravity(sheet));
  }

  async togglePause(): Promise<void> {
    const { pauseSheet, resumeSheet } = SheetService.method;
    const request = { name: this.viewer.sheetName };
    this.take(
      await this.viewer.attempt(() => (this.isPaused ? call(resumeSheet, request) : call(pauseSheet, request))),
    );
  }

  /** One tick; a running sheet is paused first. */
  async step(): Promise<void> {
    const { sheetName: name } = this.viewer;
    this.take(
      await this.viewer.attempt(async () => {
        if (!this.isPaused) await call(SheetService.method.pauseSheet, { name });
        return call(SheetService.method.stepSheet, { name, ticks: 1 });
      }),
    );
  }

  async reset(): Promise<void> {
    this.take(await this.viewer.attempt(() => call(SheetService.method.resetSheet, { name: this.viewer.sheetName })));
  }

  private take(sheet: Sheet | undefined): void {
    if (sheet) this.viewer.setSheet(sheet);
  }

  private showGravity(value: number): void {
    setText(this.gravityValue, `${value.toFixed(2)} m/s²`);
  }

  // One call at a time, always with the newest value: a dragged slider does not fill the server's queue.
  private async sendGravity(): Promise<void> {
    if (this.isSendingGravity) return;
    this.isSendingGravity = true;
    while (this.wantedGravity !== undefined) {
      const z = -this.wantedGravity;
      this.wantedGravity = undefined;
      await this.viewer.attempt(() =>
        call(InteractionService.method.setSheetGravity, {
          name: this.viewer.sheetName,
          setGravity: { gravityMps2: { x: 0, y: 0, z } },
        }),
      );
    }
    this.isSendingGravity = false;
    await this.viewer.refreshSheet();
  }
}
