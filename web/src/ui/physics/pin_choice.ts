import { call } from '../../api';
import { InteractionService } from '../../gen/kerf/v1/interaction_pb';
import type { Viewer } from '../../tools/tool';
import { countText } from '../../tools/cut_text';
import { element, setText } from '../dom';
import type { Sheet } from '../../gen/kerf/v1/sheets_pb';

/** Holds a whole edge, the corners or nothing, where it is at that moment: in place of all pins. */
export class PinChoice {
  constructor(private readonly viewer: Viewer) {
    const select = element<HTMLSelectElement>('pin-choice');
    element('pin-apply').addEventListener('click', () => void this.pin(Number(select.value)));
  }

  show({ pinnedVertices }: Sheet): void {
    setText(element('pin-count'), `${countText(pinnedVertices.length, 'vertex', 'vertices')} held`);
  }

  /** @param edge  Region.Edge; 0: nothing is held */
  private async pin(edge: number): Promise<void> {
    const pins = edge === 0 ? [] : [{ region: { case: 'edge' as const, value: edge } }];
    const { viewer } = this;
    const done = await viewer.attempt(
      () => call(InteractionService.method.setSheetPins, { name: viewer.sheetName, setPins: { pins } }),
      'The pins were not changed: ',
    );
    if (done) await viewer.refreshSheet();
  }
}
