export type ThemeChoice = 'system' | 'light' | 'dark';

const kKey = 'kerf-theme';
const kChoices: readonly ThemeChoice[] = ['system', 'light', 'dark'];
const kText: Record<ThemeChoice, string> = { system: 'as the system', light: 'light', dark: 'dark' };
const kIcons: Record<ThemeChoice, string> = { system: '#icon-system', light: '#icon-sun', dark: '#icon-moon' };

/**
 * The choice that was kept; what is no choice, or cannot be read, is the system's.
 * @param storage  asking for it may throw already
 */
export function keptChoice(storage: () => Pick<Storage, 'getItem'>): ThemeChoice {
  try {
    const kept = storage().getItem(kKey);
    return kChoices.find((choice) => choice === kept) ?? 'system';
  } catch {
    // A page that may keep nothing may ask for nothing either.
    return 'system';
  }
}

/** Light or dark: the colours follow `data-theme` of the root element (style/base.css). */
export class Theme {
  private choice = keptChoice(() => localStorage);
  private readonly system = matchMedia('(prefers-color-scheme: dark)');

  /** @param changed  called at once and with each change */
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

  /** From the system's to light to dark and round again. */
  next(): void {
    this.choice = kChoices[(kChoices.indexOf(this.choice) + 1) % kChoices.length];
    try {
      localStorage.setItem(kKey, this.choice);
    } catch {
      // Then it holds as long as the page is open.
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
