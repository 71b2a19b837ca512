import { call } from '../../api';
import { InteractionService } from '../../gen/kerf/v1/interaction_pb';
import type { Material } from '../../gen/kerf/v1/scene_pb';
import type { Sheet } from '../../gen/kerf/v1/sheets_pb';
import { Newest } from '../../newest';
import { serverInfo } from '../../server_info';
import type { OpenSheet, ShownState } from '../../sheet/open_sheet';
import { element, setText } from '../dom';
import { errorText } from '../error_text';
import { areaMassText, partName, presetOf } from '../material_text';
import { kBendingId, kMaterialQuantities, materialRefusal } from './material_quantities';
import { QuantitySlider } from './quantity_slider';

interface Change {
  /** Numbers, or a preset. */
  material: Material;
  part: number | undefined;
  /** Shows why the server refused the change. */
  refused(text: string): void;
}

const kWhole = '';
// Value of kerf.v1.SetMaterial.part for the sheet outside all parts.
const kOwn = '-1';
const kOwnNumbers = '';

/**
 * Controls the material of the sheet or of one of its parts: a preset, or numbers, which take effect while they are
 * dragged.
 */
export class MaterialControl {
  private readonly preset = element<HTMLSelectElement>('material-preset');
  private readonly part = element<HTMLSelectElement>('material-part');
  private readonly error = element('material-error');
  private readonly sliders: readonly QuantitySlider[];
  private readonly newest: Newest<Change>;
  private presets: readonly Material[] = [];
  private material: Material | undefined;
  private sheetName = '';
  // The server's material as last shown; undefined if this page has requested another since.
  private told: string | undefined;

  constructor(
    private readonly live: OpenSheet,
    shown: Pick<ShownState, 'sheet'>,
  ) {
    this.newest = new Newest(
      (name, change) => this.send(name, change),
      () => live.refresh(),
    );
    this.sliders = kMaterialQuantities.map((quantity) => {
      const slider: QuantitySlider = new QuantitySlider(quantity, (value) => {
        if (this.material) this.put(quantity.write(this.material, value), (text) => slider.refuse(text));
      });
      return slider;
    });
    element('material-rows').append(...this.sliders.map(({ row }) => row));
    this.preset.addEventListener('change', () => this.choosePreset());
    this.part.addEventListener('change', () => shown.sheet && this.show(shown.sheet));
  }

  show(sheet: Sheet): void {
    if (this.presets.length === 0) void this.fetchPresets();
    if (this.newest.isBusy) return;
    this.showParts(sheet);
    this.material = this.materialOf(sheet);
    // A refusal stays visible until the server's material changes.
    const told = JSON.stringify(this.material);
    if (this.told !== undefined && told !== this.told) this.clearErrors();
    this.told = told;
    const isPlanar = sheet.scene?.planar ?? false;
    for (const { quantity, row } of this.sliders) row.hidden = isPlanar && quantity.id === kBendingId;
    this.showNumbers();
  }

  private materialOf({ scene }: Sheet): Material | undefined {
    const { value } = this.part;
    return value === kWhole || value === kOwn ? scene?.material : scene?.materials[Number(value)]?.material;
  }

  private showParts(sheet: Sheet): void {
    const numParts = sheet.scene?.materials.length ?? 0;
    element('material-part-label').hidden = numParts === 0;
    if (sheet.name === this.sheetName && this.part.options.length === numParts + 2) return;
    this.sheetName = sheet.name;
    const parts = (sheet.scene?.materials ?? []).map(({ region }, i) => new Option(partName(region, i), String(i)));
    this.part.replaceChildren(new Option('all of it', kWhole), new Option('the rest of the sheet', kOwn), ...parts);
  }

  private showNumbers(): void {
    const { material } = this;
    if (!material) return;
    for (const slider of this.sliders) slider.show(slider.quantity.read(material));
    this.preset.value = presetOf(material, this.presets);
    setText(element('material-mass'), areaMassText(material));
  }

  private choosePreset(): void {
    const { material, presets } = this;
    const chosen = presets.find(({ preset }) => preset === this.preset.value);
    if (!material || !chosen) return this.showNumbers();
    // A preset does not change the direction of the fibres.
    this.put({ ...chosen, directionRad: material.directionRad }, (text) => {
      setText(this.error, text);
      this.error.hidden = false;
    });
  }

  private put(material: Material, refused: (text: string) => void): void {
    this.clearErrors();
    this.told = undefined;
    this.material = material;
    this.showNumbers();
    const part = this.part.value === kWhole ? undefined : Number(this.part.value);
    this.newest.put(this.live.sheetName, { material, part, refused });
  }

  private async send(name: string, { material, part, refused }: Change): Promise<void> {
    try {
      await call(InteractionService.method.setSheetMaterial, { name, setMaterial: { material, part } });
    } catch (error) {
      if (name !== this.live.sheetName) return;
      refused(materialRefusal(errorText(error as Error)));
    }
  }

  // If this fails, the next settings try again; numbers can be set without presets.
  private async fetchPresets(): Promise<void> {
    const info = await serverInfo().catch(() => undefined);
    if (!info || this.presets.length > 0) return;
    this.presets = info.materials;
    const names = this.presets.map(({ preset }) => new Option(preset, preset));
    this.preset.replaceChildren(new Option('custom', kOwnNumbers), ...names);
    this.showNumbers();
  }

  private clearErrors(): void {
    this.error.hidden = true;
    for (const slider of this.sliders) slider.clearError();
  }
}
