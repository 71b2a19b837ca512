export interface KeptRow {
  readonly item: HTMLElement;
}

/** The rows of a list by what they are of, each kept while that is there, so that whoever is in it stays in it. */
export class KeptRows<Key, Row extends KeptRow> {
  private readonly rows = new Map<Key, Row>();

  constructor(
    private readonly list: HTMLElement,
    private readonly create: (key: Key) => Row,
  ) {}

  get(key: Key): Row | undefined {
    return this.rows.get(key);
  }

  /** The rows of these, in this order; those of others go. */
  show(keys: readonly Key[]): Row[] {
    const focused = document.activeElement as HTMLElement | null;
    this.keepOnly(new Set(keys));
    const shown = keys.map((key) => this.rows.get(key) ?? this.add(key));
    shown.forEach(({ item }, i) => {
      if (this.list.children[i] !== item) this.list.insertBefore(item, this.list.children[i] ?? null);
    });
    // A row that is moved loses it.
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
