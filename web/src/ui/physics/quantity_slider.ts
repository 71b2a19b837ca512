import { make, setText } from '../dom';
import { parseQuantity, plainText, siText } from '../quantity_text';
import type { MaterialQuantity } from './material_quantities';

/** A slider with a text field for its number, such as "150 kPa". */
export class QuantitySlider {
  readonly row: HTMLElement;
  private readonly slider: HTMLInputElement;
  private readonly field: HTMLInputElement;
  private readonly error: HTMLElement;
  private shown = '';

  /** @param changed  called with a value set by the slider or in the field */
  constructor(
    readonly quantity: MaterialQuantity,
    private readonly changed: (value: number) => void,
  ) {
    const { id, name, tip, scale } = quantity;
    const [sliderId, fieldId, errorId] = ['', '-value', '-error'].map((end) => `material-${id}${end}`);
    this.slider = make('input', { type: 'range', id: sliderId, min: '0', max: String(scale.end), step: '1' });
    this.field = make('input', {
      type: 'text',
      id: fieldId,
      autocomplete: 'off',
      spellcheck: false,
      'aria-label': `${name}: ${tip}`,
      'aria-describedby': errorId,
    });
    this.error = make('p', { id: errorId, className: 'error', role: 'alert', hidden: true });
    const label = make('label', { for: sliderId }, name);
    this.row = make('div', { className: 'quantity', title: tip }, label, this.slider, this.field, this.error);
    this.slider.addEventListener('input', () => this.set(scale.valueAt(this.slider.valueAsNumber)));
    this.field.addEventListener('input', () => this.clearError());
    this.field.addEventListener('change', () => this.read());
    this.field.addEventListener('keydown', (event) => this.key(event));
  }

  show(value: number): void {
    // Does not replace text that is being typed.
    if (document.activeElement === this.field && this.field.value !== this.shown) return;
    this.shown = this.textOf(value);
    this.field.value = this.shown;
    this.slider.value = String(this.quantity.scale.placeOf(value));
    this.slider.setAttribute('aria-valuetext', this.shown);
  }

  refuse(text: string): void {
    setText(this.error, text);
    this.error.hidden = false;
    this.field.setAttribute('aria-invalid', 'true');
  }

  clearError(): void {
    setText(this.error, '');
    this.error.hidden = true;
    this.field.removeAttribute('aria-invalid');
  }

  private textOf(value: number): string {
    const { unit, isSi } = this.quantity;
    return isSi ? siText(value, unit) : plainText(value, unit);
  }

  private set(value: number): void {
    // The typed text has been read, so show() may replace it.
    this.shown = this.field.value;
    this.show(value);
    this.changed(value);
  }

  private read(): void {
    const { name, unit, isSi, scale } = this.quantity;
    const value = parseQuantity(this.field.value, unit, isSi);
    if (value !== undefined) return this.set(value);
    this.refuse(`Give ${name} as a number, such as ${this.textOf(scale.valueAt(scale.end / 2))}`);
  }

  // Escape first undoes typing; only the next Escape closes the panel.
  private key(event: KeyboardEvent): void {
    if (event.key !== 'Escape' || this.field.value === this.shown) return;
    event.preventDefault();
    this.field.value = this.shown;
    this.clearError();
  }
}
