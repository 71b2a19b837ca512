import type { Sheet } from '../../gen/kerf/v1/sheets_pb';
import type { Reporter } from '../../notifier';
import type { OpenSheet, ShownState } from '../../sheet/open_sheet';
import { GravityControl } from './gravity_control';
import { MaterialControl } from './material_control';
import { PinChoice } from './pin_choice';
import { SelfContactControl } from './self_contact_control';
import { SofteningNote } from './softening_note';
import { WindControl } from './wind_control';

/** The controls of gravity, wind, pins, material and self-contact. */
export class PhysicsPanel {
  private readonly parts: readonly { show(sheet: Sheet): void }[];

  constructor(live: OpenSheet, shown: Pick<ShownState, 'sheet'>, reporter: Reporter) {
    this.parts = [
      new GravityControl(live, reporter),
      new WindControl(live, reporter),
      new PinChoice(live, reporter),
      new MaterialControl(live, shown),
      new SofteningNote(),
      new SelfContactControl(live, reporter),
    ];
  }

  /** Shows the settings in force. */
  show(sheet: Sheet): void {
    for (const part of this.parts) part.show(sheet);
  }
}
