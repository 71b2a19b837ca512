import { call } from '../api';
import { SheetService } from '../gen/kerf/v1/sheets_pb';
import type { Sheet } from '../gen/kerf/v1/sheets_pb';
import { Newest } from '../newest';
import type { Reporter } from '../notifier';
import type { OpenSheet } from '../sheet/open_sheet';
import { element } from './dom';
import { kSpeeds, nextSpeed, speedOf, speedText } from './speeds';

/** Controls slow motion and time lapse: ticks with the same results, farther apart or closer together in time. */
export class SpeedControl {
  private readonly select = element<HTMLSelectElement>('speed');
  private readonly newest: Newest<number>;
  private speed = 1;

  constructor(
    private readonly live: OpenSheet,
    reporter: Reporter,
  ) {
    this.newest = new Newest(
      (name, speed) =>
        reporter.attempt(() => call(SheetService.method.setSheetSpeed, { name, speed }), 'The speed was not changed: '),
      () => live.refresh(),
    );
    this.select.addEventListener('change', () => this.set(Number(this.select.value)));
  }

  show(sheet: Sheet): void {
    if (!this.newest.isBusy) this.showSpeed(speedOf(sheet));
  }

  set(speed: number): void {
    if (speed === this.speed) return;
    this.showSpeed(speed);
    this.newest.put(this.live.sheetName, speed);
  }

  step(direction: 1 | -1): void {
    this.set(nextSpeed(this.speed, direction));
  }

  // Adds the speed to the list if it is missing, because another client may have set it.
  private showSpeed(speed: number): void {
    this.speed = speed;
    const speeds = [...new Set([...kSpeeds, speed])].sort((a, b) => a - b);
    if (this.select.options.length !== speeds.length || ![...this.select.options].some(({ value }) => Number(value) === speed)) {
      this.select.replaceChildren(...speeds.map((each) => new Option(speedText(each), String(each))));
    }
    this.select.value = String(speed);
    this.select.classList.toggle('changed', speed !== 1);
  }
}
