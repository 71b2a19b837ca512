// A stream that begins again, such as after a change of colours, ends and joins within this time.
const kAwayMs = 5000;

/** Finds who has joined. A person who is back within a few seconds had not left. */
export class Arrivals {
  // Names by their viewer; undefined before the first list.
  private present: ReadonlyMap<number, string> | undefined;
  private left: { name: string; atMs: number }[] = [];

  /**
   * Takes all who are there now, as numbers and names.
   * @param persons  names that stand for one person each: who is there with one page does not join with another. A page
   *     that begins its stream again is seen twice for a moment.
   * @returns the names of those who have joined; none for the first list
   */
  saw(people: ReadonlyMap<number, string>, nowMs: number, persons: ReadonlySet<string> = new Set()): string[] {
    const before = this.present;
    this.present = people;
    if (!before) return [];
    this.left = this.left.filter(({ atMs }) => nowMs - atMs < kAwayMs);
    for (const [number, name] of before) {
      if (!people.has(number)) this.left.push({ name, atMs: nowMs });
    }
    const known = new Set([...before.values()].filter((name) => persons.has(name)));
    const come = [...people].filter(([number, name]) => !before.has(number) && !known.has(name)).map(([, name]) => name);
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
