import { call } from '../../api';
import { InteractionService } from '../../gen/kerf/v1/interaction_pb';
import type { Reporter } from '../../notifier';
import type { OpenSheet } from '../../sheet/open_sheet';
import { countText } from '../../tools/cut_text';
import { element, setText } from '../dom';
import type { Sheet } from '../../gen/kerf/v1/sheets_pb';

/** Replaces all pins: holds a whole edge, the corners or nothing, at the present place. */
export class PinChoice {
  constructor(
    private readonly live: OpenSheet,
    private readonly reporter: Reporter,
  ) {
    const select = element<HTMLSelectElement>('pin-choice');
    element('pin-apply').addEventListener('click', () => void this.pin(Number(select.value)));
  }

  show({ pinnedVertices }: Sheet): void {
    setText(element('pin-count'), `${countText(pinnedVertices.length, 'vertex', 'vertices')} held`);
  }

  /** @param edge  Region.Edge; 0: nothing is held */
  private async pin(edge: number): Promise<void> {
    const pins = edge === 0 ? [] : [{ region: { case: 'edge' as const, value: edge } }];
    const { live } = this;
    const done = await this.reporter.attempt(
      () => call(InteractionService.method.setSheetPins, { name: live.sheetName, setPins: { pins } }),
      'The pins were not changed: ',
    );
    if (done) await live.refresh();
  }
}
