import type { Sheet } from '../gen/kerf/v1/sheets_pb';
import { MaterialParts } from '../geometry/material_parts';
import { kLooks, lookName } from './material_looks';
import type { LookFinder, SheetView } from './sheet_view';

type LookedAt = Pick<Sheet, 'name' | 'createdUnixUs' | 'scene' | 'components'>;

/** Gives each part of a sheet the look of its material. */
export class SheetLooks {
  private sheet = '';
  private parts: MaterialParts | undefined;
  private names: readonly string[] = [];
  private finder: LookFinder = () => undefined;

  /** Shows the looks of these settings. */
  show(sheet: LookedAt, view: Pick<SheetView, 'setLooks'>): void {
    const { scene } = sheet;
    // A sheet keeps its parts, and only their materials change.
    const key = `${sheet.name} ${sheet.createdUnixUs}`;
    const names = [scene?.material, ...(scene?.materials ?? []).map(({ material }) => material)].map(lookName);
    if (key !== this.sheet || String(names) !== String(this.names)) {
      if (key !== this.sheet) this.parts = new MaterialParts(sheet);
      [this.sheet, this.names] = [key, names];
      this.finder = this.finderOf(this.parts!);
    }
    view.setLooks(this.different().map((name) => kLooks[name]), this.finder);
  }

  private different(): string[] {
    return [...new Set(this.names)];
  }

  private finderOf(parts: MaterialParts): LookFinder {
    const different = this.different();
    if (different.length === 1) return () => undefined;
    const numbers = this.names.map((name) => different.indexOf(name));
    return (mesh) => parts.ofTriangles(mesh).map((part) => numbers[part]);
  }
}
