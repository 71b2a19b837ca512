import { call } from '../../api';
import { InteractionService } from '../../gen/kerf/v1/interaction_pb';
import type { Sheet } from '../../gen/kerf/v1/sheets_pb';
import { Newest } from '../../newest';
import type { Reporter } from '../../notifier';
import type { OpenSheet } from '../../sheet/open_sheet';
import { element, setText } from '../dom';

// The default of kerf.v1.Scene.gravity_mps2.
const kDefaultMps2 = 9.81;

/** Downward acceleration, metres per second squared. */
export class GravityControl {
  private readonly slider = element<HTMLInputElement>('gravity');
  private readonly value = element('gravity-value');
  private readonly newest: Newest<number>;

  constructor(
    private readonly live: OpenSheet,
    reporter: Reporter,
  ) {
    this.newest = new Newest(
      (name, mps2) =>
        reporter.attempt(() =>
          call(InteractionService.method.setSheetGravity, {
            name,
            setGravity: { gravityMps2: { x: 0, y: 0, z: -mps2 } },
          }),
        ),
      () => live.refresh(),
    );
    this.slider.addEventListener('input', () => this.set(this.slider.valueAsNumber));
    for (const button of document.querySelectorAll<HTMLElement>('[data-gravity]')) {
      button.addEventListener('click', () => {
        this.slider.value = button.dataset.gravity!;
        this.set(Number(button.dataset.gravity));
      });
    }
  }

  show({ scene }: Sheet): void {
    if (this.newest.isBusy) return;
    const mps2 = scene?.gravityMps2 ? -scene.gravityMps2.z : kDefaultMps2;
    this.slider.value = String(mps2);
    this.showValue(mps2);
  }

  private set(mps2: number): void {
    this.showValue(mps2);
    this.newest.put(this.live.sheetName, mps2);
  }

  private showValue(mps2: number): void {
    setText(this.value, `${mps2.toFixed(2)} m/s²`);
  }
}
