// Reads every import of src/, types included, and compares it with the table of who may import whom. A file in no row
// fails, so that a new folder has to be thought about. A row without files fails as well, and so does a circle of files.

import { readFileSync, readdirSync } from 'node:fs';
import { posix } from 'node:path';
import ts from 'typescript';
import { describe, expect, it } from 'vitest';

const kSource = new URL('../src/', import.meta.url);

/** A folder of src/ with all that is below it, or a single file. */
interface Row {
  readonly part: string;
  /** The parts that it may import beside itself and src/gen. */
  readonly mayImport: readonly string[];
}

// Files that speak with the server or the user, and know no other part.
const kCalls = ['api.ts', 'newest.ts', 'newest_answer.ts', 'notifier.ts', 'server_info.ts', 'sheets.ts'];
const kParts = ['stream', 'geometry', 'scene', 'sheet', 'tools', 'ui'];

const kTable: readonly Row[] = [
  { part: 'gen', mayImport: [] },
  { part: 'api.ts', mayImport: [] },
  { part: 'newest.ts', mayImport: [] },
  { part: 'newest_answer.ts', mayImport: [] },
  { part: 'notifier.ts', mayImport: [] },
  { part: 'server_info.ts', mayImport: ['api.ts'] },
  { part: 'sheets.ts', mayImport: ['api.ts'] },
  { part: 'stream', mayImport: ['api.ts'] },
  { part: 'geometry', mayImport: ['stream'] },
  { part: 'scene', mayImport: ['geometry', 'stream'] },
  { part: 'sheet', mayImport: [...kCalls, 'scene', 'geometry', 'stream'] },
  { part: 'tools', mayImport: [...kCalls, 'sheet', 'scene', 'geometry'] },
  { part: 'ui', mayImport: [...kCalls, 'tools', 'sheet', 'scene', 'geometry', 'stream'] },
  { part: 'hooks.ts', mayImport: kParts },
  { part: 'app.ts', mayImport: ['hooks.ts', ...kParts] },
  { part: 'main.ts', mayImport: ['app.ts', 'ui/access/link_code.ts', 'ui/dom.ts'] },
];

/** Imports of each file, as paths from src/. */
type Imports = ReadonlyMap<string, readonly string[]>;

function isIn(path: string, part: string): boolean {
  return path === part || path.startsWith(`${part}/`);
}

/** Modules of src/ that a file imports in any way, types included. */
function importsOf(file: string, source: string): string[] {
  const { importedFiles } = ts.preProcessFile(source, true, true);
  const own = importedFiles.map(({ fileName }) => fileName).filter((name) => name.startsWith('.'));
  return own.map((name) => `${posix.join(posix.dirname(file), name).replace(/\.ts$/, '')}.ts`);
}

function importsInSource(): Imports {
  const files = readdirSync(kSource, { recursive: true, encoding: 'utf8' }).map((file) => file.replaceAll('\\', '/'));
  const sources = files.filter((file) => file.endsWith('.ts'));
  return new Map(sources.map((file) => [file, importsOf(file, readFileSync(new URL(file, kSource), 'utf8'))]));
}

/** Every import that the table does not allow, as "file: import". */
function violations(imports: Imports): string[] {
  return [...imports].flatMap(([file, imported]) => {
    const row = kTable.find(({ part }) => isIn(file, part));
    if (!row) return [`${file}: it is in no row of the table`];
    const allowed = ['gen', row.part, ...row.mayImport];
    return imported.filter((to) => !allowed.some((part) => isIn(to, part))).map((to) => `${file}: ${to}`);
  });
}

/** A circle of files, each importing the next, and the last the first; undefined if there is none. */
function circle(imports: Imports): string[] | undefined {
  const done = new Set<string>();
  const way: string[] = [];
  const visit = (file: string): string[] | undefined => {
    if (way.includes(file)) return way.slice(way.indexOf(file));
    if (done.has(file)) return undefined;
    way.push(file);
    for (const to of imports.get(file) ?? []) {
      const found = visit(to);
      if (found) return found;
    }
    way.pop();
    done.add(file);
    return undefined;
  };
  for (const file of imports.keys()) {
    const found = visit(file);
    if (found) return found;
  }
  return undefined;
}

describe('imports of the viewer', () => {
  const imports = importsInSource();

  it('are those of the table', () => {
    expect(violations(imports)).toEqual([]);
    // Guards against a search that finds nearly nothing.
    expect(imports.size).toBeGreaterThan(100);
  });

  it('make no circle', () => {
    expect(circle(imports)).toBeUndefined();
  });

  it('find the joining of all parts in app.ts, which main.ts alone imports', () => {
    const importers = [...imports].filter(([, imported]) => imported.includes('app.ts')).map(([file]) => file);
    expect(importers).toEqual(['main.ts']);
  });

  it('are of files that are there, as is every part that the table names', () => {
    const files = [...imports.keys()];
    expect([...imports.values()].flat().filter((to) => !imports.has(to))).toEqual([]);
    const named = kTable.flatMap(({ part, mayImport }) => [part, ...mayImport]);
    expect(named.filter((part) => !files.some((file) => isIn(file, part)))).toEqual([]);
  });
});

// Tries the check itself on faults put there on purpose.
describe('the check of imports', () => {
  it.each([
    ['ui/menu.ts', "import { App } from '../app';", true],
    ['ui/menu.ts', "import type { App } from '../app';", true],
    ['ui/physics/wind.ts', "let app: import('../../app').App;", true],
    ['ui/menu.ts', "const app = await import('../app');", true],
    ['ui/menu.ts', "export type { App } from '../app';", true],
    ['ui/menu.ts', "import '../app';", true],
    ['hooks.ts', "import type { App } from './app';", true],
    ['ui/menu.ts', "// import { App } from '../app';", false],
    ['main.ts', "import { App } from './app';", false],
    ['tools/cut_tool.ts', "import type { Notices } from '../ui/notices';", true],
    ['scene/stage.ts', "import type { Tool } from '../tools/tool';", true],
    ['stream/watch.ts', "import { Surface } from '../geometry/surface';", true],
    ['stream/watch.ts', "import { FrameSchema } from '../gen/kerf/v1/stream_pb';", false],
    ['ui/sheets/sheet_list.ts', "import { element } from '../dom';", false],
    ['ui/menu.ts', "import { Vector2 } from 'three';", false],
    ['teapot/brew.ts', '', true],
    ['tooling/brew.ts', '', true],
  ])('judges %s with %s', (file, line, isViolation) => {
    const imported = importsOf(file, `import ts from 'typescript';\n${line}\nexport const x = 1;\n`);
    expect(violations(new Map([[file, imported]])).length > 0).toBe(isViolation);
  });

  it('names file and import', () => {
    expect(violations(new Map([['scene/stage.ts', ['app.ts']]]))).toEqual(['scene/stage.ts: app.ts']);
  });

  it('finds a circle, and none where two ways lead to one file', () => {
    const ways: [string, string[]][] = [['a.ts', ['b.ts', 'c.ts']], ['b.ts', ['d.ts']], ['c.ts', ['d.ts']], ['d.ts', []]];
    expect(circle(new Map(ways))).toBeUndefined();
    expect(circle(new Map([...ways, ['d.ts', ['b.ts']]]))).toEqual(['b.ts', 'd.ts']);
  });
});
