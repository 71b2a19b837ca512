import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import { FileDrop } from '../src/ui/file_drop';

function dragEvent(name: string, fileNames: string[]): Event & { dataTransfer: { dropEffect: string } } {
  const files = fileNames.map((fileName) => ({ name: fileName }));
  const dataTransfer = { types: fileNames.length > 0 ? ['Files'] : ['text/plain'], files, dropEffect: 'copy' };
  return Object.assign(new Event(name, { cancelable: true }), { dataTransfer });
}

describe('FileDrop', () => {
  const taken: string[] = [];
  let page: EventTarget;
  let stage: EventTarget;

  beforeEach(() => {
    taken.length = 0;
    page = new EventTarget();
    stage = Object.assign(new EventTarget(), { classList: { add: () => {}, remove: () => {} } });
    vi.stubGlobal('addEventListener', page.addEventListener.bind(page));
    vi.stubGlobal('document', { getElementById: () => stage });
    const take = (kind: string) => (file: File) => void taken.push(`${kind} ${file.name}`);
    new FileDrop({ mesh: take('mesh'), frames: take('frames'), run: take('run'), drawing: take('drawing') });
  });
  afterEach(() => vi.unstubAllGlobals());

  it('tells files on the sheet by their names', () => {
    const drops = ['a.OBJ', 'a.kerfstream', 'a.rec', 'a.svg'].map((name) => dragEvent('drop', [name]));
    for (const drop of drops) stage.dispatchEvent(drop);
    expect(taken).toEqual(['mesh a.OBJ', 'frames a.kerfstream', 'run a.rec', 'drawing a.svg']);
    expect(drops.every((drop) => drop.defaultPrevented)).toBe(true);
  });

  it.each(['dragover', 'drop'])('keeps the page where a file is beside the sheet: %s', (name) => {
    const event = dragEvent(name, ['a.svg']);
    page.dispatchEvent(event);
    expect([event.defaultPrevented, event.dataTransfer.dropEffect]).toEqual([true, 'none']);
    expect(taken).toEqual([]);
  });

  it('leaves to the browser what is no file, and to others what they take', () => {
    const text = dragEvent('drop', []);
    page.dispatchEvent(text);
    expect(text.defaultPrevented).toBe(false);
    const own = dragEvent('dragover', ['a.svg']);
    own.preventDefault();
    page.dispatchEvent(own);
    expect(own.dataTransfer.dropEffect).toBe('copy');
  });
});
