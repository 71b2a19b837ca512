/** A menu that a button opens by toggle(). Arrow keys move in it; Escape, a choice or a press elsewhere closes it. */
export class Menu {
  private readonly items: HTMLButtonElement[];

  /** @param panel  element whose buttons are the items */
  constructor(
    private readonly button: HTMLButtonElement,
    private readonly panel: HTMLElement,
    private readonly opening: () => void,
  ) {
    this.items = [...panel.querySelectorAll<HTMLButtonElement>('[role=menuitem]')];
    button.setAttribute('aria-haspopup', 'menu');
    button.setAttribute('aria-expanded', 'false');
    panel.addEventListener('click', (event) => {
      if ((event.target as HTMLElement).closest('[role=menuitem]')) this.close();
    });
    panel.addEventListener('keydown', (event) => this.key(event));
    addEventListener('pointerdown', (event) => {
      const { target } = event;
      if (this.isOpen && !panel.contains(target as Node) && !button.contains(target as Node)) this.close();
    });
  }

  get isOpen(): boolean {
    return !this.panel.hidden;
  }

  toggle(): void {
    if (this.isOpen) return this.close();
    this.opening();
    this.show(true);
    this.items.find((item) => !item.disabled)?.focus();
  }

  close(): void {
    if (!this.isOpen) return;
    const hadFocus = this.panel.contains(document.activeElement);
    this.show(false);
    if (hadFocus) this.button.focus();
  }

  private show(isOpen: boolean): void {
    this.panel.hidden = !isOpen;
    this.button.setAttribute('aria-expanded', String(isOpen));
  }

  private key(event: KeyboardEvent): void {
    const { key } = event;
    // Keeps keys from the viewer's shortcuts; Space and Enter press the item.
    event.stopPropagation();
    if (key === 'Escape' || key === 'Tab') return this.close();
    const step = key === 'ArrowDown' ? 1 : key === 'ArrowUp' ? -1 : 0;
    if (step === 0) return;
    event.preventDefault();
    const enabled = this.items.filter((item) => !item.disabled);
    const at = enabled.indexOf(document.activeElement as HTMLButtonElement);
    enabled[(at + step + enabled.length) % enabled.length]?.focus();
  }
}
