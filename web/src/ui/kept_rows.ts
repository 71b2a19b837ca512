export interface KeptRow {
  readonly item: HTMLElement;
}

/**
 * Keeps the rows of a list by their keys. A row stays the same element while its key is listed, so that it keeps the
 * focus.
 */
export class KeptRows<Key, Row extends KeptRow> {
  private readonly rows = new Map<Key, Row>();

  constructor(
    private readonly list: HTMLElement,
    private readonly create: (key: Key) => Row,
  ) {}

  get(key: Key): Row | undefined {
    return this.rows.get(key);
  }

  /** Shows the rows of these keys, in this order, and removes all others. */
  show(keys: readonly Key[]): Row[] {
    const focused = document.activeElement as HTMLElement | null;
    this.keepOnly(new Set(keys));
    const shown = keys.map((key) => this.rows.get(key) ?? this.add(key));
    shown.forEach(({ item }, i) => {
      if (this.list.children[i] !== item) this.list.insertBefore(item, this.list.children[i] ?? null);
    });
    // Restores the focus, which a moved row loses.
    if (focused && this.list.contains(focused)) focused.focus({ preventScroll: true });
    return shown;
  }

  private keepOnly(keys: ReadonlySet<Key>): void {
    for (const [key, { item }] of this.rows) {
      if (keys.has(key)) continue;
      item.remove();
      this.rows.delete(key);
    }
  }

  private add(key: Key): Row {
    const row = this.create(key);
    this.rows.set(key, row);
    return row;
  }
}
