/** Returns the element of index.html with this id. */
export function element<T extends HTMLElement = HTMLElement>(id: string): T {
  const found = document.getElementById(id);
  if (!found) throw new Error(`index.html has no #${id}`);
  return found as T;
}

/** Replaces text only if it differs, so that a line updated every frame needs no layout. */
export function setText(target: HTMLElement, text: string): void {
  if (target.textContent !== text) target.textContent = text;
}

/** Enables or disables all controls that act on the live sheet: elements with data-live. */
export function setLiveControls(isOn: boolean): void {
  for (const control of document.querySelectorAll<HTMLElement>('[data-live]')) control.inert = !isOn;
}

/** A group of buttons of which one is chosen; arrow keys move between them. */
export class Choice<T extends string> {
  private readonly buttons: HTMLButtonElement[];

  /** @param attribute  name of the data attribute that holds each button's value */
  constructor(
    container: HTMLElement,
    private readonly attribute: string,
    chosen: (value: T) => void,
  ) {
    this.buttons = [...container.querySelectorAll<HTMLButtonElement>(`[data-${attribute}]`)];
    this.buttons.forEach((button, i) => {
      button.addEventListener('click', () => chosen(button.dataset[attribute] as T));
      button.addEventListener('keydown', ({ key }) => {
        const step =
          key === 'ArrowDown' || key === 'ArrowRight' ? 1 : key === 'ArrowUp' || key === 'ArrowLeft' ? -1 : 0;
        if (step === 0) return;
        const next = this.buttons[(i + step + this.buttons.length) % this.buttons.length];
        next.focus();
        next.click();
      });
    });
  }

  show(value: T): void {
    for (const button of this.buttons) {
      const isChosen = button.dataset[this.attribute] === value;
      button.setAttribute('aria-checked', String(isChosen));
      button.tabIndex = isChosen ? 0 : -1;
    }
  }
}

/** Makes an element with these properties and children. Names with a dash, `role` and `for` are set as attributes. */
export function make<K extends keyof HTMLElementTagNameMap>(
  tag: K,
  properties: Record<string, string | boolean | number>,
  ...children: (Node | string)[]
): HTMLElementTagNameMap[K] {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(properties)) {
    if (name.includes('-') || name === 'role' || name === 'for') made.setAttribute(name, String(value));
    else Object.assign(made, { [name]: value });
  }
  made.append(...children);
  return made;
}

/** Returns an element that draws the icon `icon-NAME` of index.html. */
export function icon(name: string): SVGSVGElement {
  const kSvg = 'http://www.w3.org/2000/svg';
  const svg = document.createElementNS(kSvg, 'svg');
  const use = document.createElementNS(kSvg, 'use');
  use.setAttribute('href', `#icon-${name}`);
  svg.setAttribute('aria-hidden', 'true');
  svg.append(use);
  return svg;
}
