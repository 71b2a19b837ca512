// A stream that begins again, such as after a change of colours, ends and joins within this time.
const kAwayMs = 5000;

/** Finds who has joined. A person who is back within a few seconds had not left. */
export class Arrivals {
  // Names by their viewer; undefined before the first list.
  private present: ReadonlyMap<number, string> | undefined;
  private left: { name: string; atMs: number }[] = [];

  /**
   * Takes all who are there now, as numbers and names.
   * @returns the names of those who have joined; none for the first list
   */
  saw(people: ReadonlyMap<number, string>, nowMs: number): string[] {
    const before = this.present;
    this.present = people;
    if (!before) return [];
    this.left = this.left.filter(({ atMs }) => nowMs - atMs < kAwayMs);
    for (const [number, name] of before) {
      if (!people.has(number)) this.left.push({ name, atMs: nowMs });
    }
    const come = [...people].filter(([number]) => !before.has(number)).map(([, name]) => name);
    return come.filter((name) => {
      const at = this.left.findIndex((gone) => gone.name === name);
      if (at < 0) return true;
      this.left.splice(at, 1);
      return false;
    });
  }

  /** Begins again with the next list. */
  clear(): void {
    this.present = undefined;
    this.left = [];
  }
}
