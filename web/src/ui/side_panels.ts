import { element } from './dom';

/** Callbacks of a panel. */
export interface Panel {
  opened(): void;
  closed(): void;
}

/**
 * Panels at the side, on a phone at the bottom; at most one is open. Each has a button [data-panel=ID] in #panel-bar and
 * an element #panel-ID with a button [data-close].
 */
export class SidePanels {
  private readonly panels = new Map<string, Panel>();
  private current: string | undefined;

  /** @param changed  called when a panel was opened or closed */
  constructor(private readonly changed: () => void) {
    for (const button of element('panel-bar').querySelectorAll<HTMLElement>('[data-panel]')) {
      const id = button.dataset.panel!;
      button.setAttribute('aria-controls', `panel-${id}`);
      button.setAttribute('aria-expanded', 'false');
      const panel = this.elementOf(id);
      panel.querySelector('[data-close]')!.addEventListener('click', () => this.close());
      panel.addEventListener('keydown', (event) => {
        if (event.key !== 'Escape' || event.defaultPrevented) return;
        event.preventDefault();
        this.close();
      });
    }
  }

  /** Id of the open panel; undefined: none. */
  get open(): string | undefined {
    return this.current;
  }

  add(id: string, panel: Panel): void {
    this.panels.set(id, panel);
  }

  /** Opens or closes a panel. A panel opened by the keyboard gets the focus. */
  toggle(id: string): void {
    if (this.current === id) {
      this.close();
      return;
    }
    this.hide();
    this.current = id;
    document.body.dataset.panel = id;
    this.elementOf(id).hidden = false;
    this.buttonOf(id).setAttribute('aria-expanded', 'true');
    this.panels.get(id)?.opened();
    this.elementOf(id).focus({ preventScroll: true });
    this.changed();
  }

  /** Closes the open panel; false if none is open. */
  close(): boolean {
    const id = this.current;
    if (id === undefined) return false;
    const hadFocus = this.elementOf(id).contains(document.activeElement);
    this.hide();
    if (hadFocus) this.buttonOf(id).focus();
    this.changed();
    return true;
  }

  private hide(): void {
    const id = this.current;
    if (id === undefined) return;
    this.current = undefined;
    delete document.body.dataset.panel;
    this.elementOf(id).hidden = true;
    this.buttonOf(id).setAttribute('aria-expanded', 'false');
    this.panels.get(id)?.closed();
  }

  private elementOf(id: string): HTMLElement {
    return element(`panel-${id}`);
  }

  private buttonOf(id: string): HTMLElement {
    return document.querySelector<HTMLElement>(`#panel-bar [data-panel=${id}]`)!;
  }
}
