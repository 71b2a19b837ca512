import { vi } from 'vitest';

/** Parts of an element that the viewer's controls use. */
export class FakeElement extends EventTarget {
  hidden = false;
  textContent = '';
  value = '';
  checked = false;
  files: File[] = [];
  options: object[] = [];
  readonly style = {};
  readonly classList = { toggle: () => {} };

  get valueAsNumber(): number {
    return Number(this.value);
  }

  setAttribute(): void {}

  append(): void {}

  replaceChildren(...children: object[]): void {
    this.options = children;
  }

  /** Acts as if a user had set it. */
  enter(value: string, event: string): void {
    this.value = value;
    this.dispatchEvent(new Event(event));
  }
}

/** A page that has every element that is asked for, by its id. */
export function fakePage(): (id: string) => FakeElement {
  const elements = new Map<string, FakeElement>();
  const byId = (id: string) => {
    const found = elements.get(id) ?? new FakeElement();
    elements.set(id, found);
    return found;
  };
  vi.stubGlobal('document', {
    getElementById: byId,
    querySelectorAll: () => [],
    createElement: () => new FakeElement(),
  });
  vi.stubGlobal('Option', class {});
  return byId;
}
