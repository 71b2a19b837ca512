import type { Sheet } from '../../gen/kerf/v1/sheets_pb';
import type { Viewer } from '../../tools/tool';
import { GravityControl } from './gravity_control';
import { MaterialControl } from './material_control';
import { PinChoice } from './pin_choice';
import { SofteningNote } from './softening_note';
import { WindControl } from './wind_control';

/** What acts on the sheet: gravity, wind, pins; and what it is made of. */
export class PhysicsPanel {
  private readonly parts: readonly { show(sheet: Sheet): void }[];

  constructor(viewer: Viewer) {
    this.parts = [
      new GravityControl(viewer),
      new WindControl(viewer),
      new PinChoice(viewer),
      new MaterialControl(viewer),
      new SofteningNote(),
    ];
  }

  /** Shows the settings in force. */
  show(sheet: Sheet): void {
    for (const part of this.parts) part.show(sheet);
  }
}
