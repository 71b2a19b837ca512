export type ThemeChoice = 'system' | 'light' | 'dark';

const kKey = 'kerf-theme';
const kChoices: readonly ThemeChoice[] = ['system', 'light', 'dark'];
const kText: Record<ThemeChoice, string> = { system: 'as the system', light: 'light', dark: 'dark' };
const kIcons: Record<ThemeChoice, string> = { system: '#icon-system', light: '#icon-sun', dark: '#icon-moon' };

/**
 * Returns the stored choice; 'system' if it is invalid or cannot be read.
 * @param storage  may throw
 */
export function keptChoice(storage: () => Pick<Storage, 'getItem'>): ThemeChoice {
  try {
    const kept = storage().getItem(kKey);
    return kChoices.find((choice) => choice === kept) ?? 'system';
  } catch {
    // A page without permission to store cannot read either.
    return 'system';
  }
}

/** Controls light and dark: the colours follow `data-theme` of the root element (style/base.css). */
export class Theme {
  private choice = keptChoice(() => localStorage);
  private readonly system = matchMedia('(prefers-color-scheme: dark)');

  /** @param changed  called in the constructor and after each change */
  constructor(
    private readonly button: HTMLElement,
    private readonly changed: (isDark: boolean) => void,
  ) {
    this.system.addEventListener('change', () => this.show());
    this.show();
  }

  get isDark(): boolean {
    return this.choice === 'dark' || (this.choice === 'system' && this.system.matches);
  }

  /** Changes from the system's choice to light, to dark, and back to the system's. */
  next(): void {
    this.choice = kChoices[(kChoices.indexOf(this.choice) + 1) % kChoices.length];
    try {
      localStorage.setItem(kKey, this.choice);
    } catch {
      // Without storage the choice lasts only while the page is open.
    }
    this.show();
  }

  private show(): void {
    document.documentElement.dataset.theme = this.choice;
    this.button.querySelector('use')!.setAttribute('href', kIcons[this.choice]);
    this.button.querySelector('span')!.textContent = `Theme: ${kText[this.choice]}`;
    this.changed(this.isDark);
  }
}
