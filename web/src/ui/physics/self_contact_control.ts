import { call } from '../../api';
import { InteractionService } from '../../gen/kerf/v1/interaction_pb';
import { SelfContact_Mode } from '../../gen/kerf/v1/scene_pb';
import type { Sheet } from '../../gen/kerf/v1/sheets_pb';
import { Newest } from '../../newest';
import type { Reporter } from '../../notifier';
import type { OpenSheet } from '../../sheet/open_sheet';
import { element, setText } from '../dom';

interface Setting {
  isOn: boolean;
  friction: number;
}

// The default of kerf.v1.SelfContact.friction.
const kDefaultFriction = 0.3;

/** Turns contact of the sheet with itself on and off, and sets its friction. The thickness stays as it is. */
export class SelfContactControl {
  private readonly isOn = element<HTMLInputElement>('self-contact-on');
  private readonly slider = element<HTMLInputElement>('self-contact-friction');
  private readonly newest: Newest<Setting>;
  // As the server or the slider said last; it may be beyond the end of the slider.
  private friction = kDefaultFriction;

  constructor(
    private readonly live: OpenSheet,
    reporter: Reporter,
  ) {
    this.newest = new Newest(
      (name, { isOn, friction }) =>
        reporter.attempt(() =>
          call(InteractionService.method.setSheetSelfContact, {
            name,
            setSelfContact: { mode: isOn ? SelfContact_Mode.ON : SelfContact_Mode.OFF, friction },
          }),
        ),
      () => live.refresh(),
    );
    this.isOn.addEventListener('input', () => this.put());
    this.slider.addEventListener('input', () => {
      this.friction = this.slider.valueAsNumber;
      this.put();
    });
  }

  show({ scene }: Sheet): void {
    if (this.newest.isBusy) return;
    this.isOn.checked = scene?.selfContact?.mode === SelfContact_Mode.ON;
    this.friction = scene?.selfContact?.friction ?? kDefaultFriction;
    this.slider.value = String(this.friction);
    this.showFriction();
  }

  private put(): void {
    this.showFriction();
    this.newest.put(this.live.sheetName, { isOn: this.isOn.checked, friction: this.friction });
  }

  private showFriction(): void {
    setText(element('self-contact-friction-value'), this.friction.toFixed(2));
  }
}
