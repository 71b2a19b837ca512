import type { Sheet } from '../../gen/kerf/v1/sheets_pb';
import { element, make } from '../dom';
import { materialFacts } from '../material_text';

/** The numbers of what the sheet is made of. */
export class MaterialFacts {
  private readonly list = element('material-facts');
  private shown = '';

  show({ scene }: Sheet): void {
    const facts = scene?.material ? materialFacts(scene.material) : [];
    const text = facts.join();
    if (text === this.shown) return;
    this.shown = text;
    this.list.replaceChildren(
      ...facts.map(([name, value]) => make('div', {}, make('dt', {}, name), make('dd', {}, value))),
    );
  }
}
