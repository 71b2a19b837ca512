import type { Ray } from 'three';
import { Vector2 } from 'three';
import { beforeEach, describe, expect, it } from 'vitest';
import { PinTool } from '../src/tools/pin_tool';
import type { Viewer } from '../src/tools/tool';
import { HeldCalls } from './support/held_calls';

describe('PinTool', () => {
  let server: HeldCalls;
  let notices: string[];
  let live: { sheetName: string };
  let shown: { sheet: { pinnedVertices: number[] } | undefined };
  let told: () => void;
  let tool: PinTool;
  // Far from where the pins are seen, so that it is the vertex that is picked.
  const tap = (vertex: number) => tool.tap({ px: new Vector2(), ray: { vertex } as unknown as Ray });
  const asked = () =>
    server.calls.map(({ request: { name, setPins } }) => {
      const { pins = [] } = setPins as { pins?: { vertices: { vertices: number[] } }[] };
      return [name, ...pins.flatMap(({ vertices }) => vertices.vertices)];
    });

  beforeEach(() => {
    server = new HeldCalls();
    notices = [];
    const surface = { pick: ({ vertex }: { vertex: number }) => ({ vertex }), hasMaterial: () => false };
    live = { sheetName: 'sheets/a' };
    shown = { sheet: { pinnedVertices: [3] } };
    Object.assign(live, { refresh: () => new Promise<void>((resolve) => (told = resolve)) });
    Object.assign(shown, { surface });
    const reporter = {
      notify: (_: string, text: string) => notices.push(text),
      attempt: (run: () => Promise<unknown>) => run().catch(() => undefined),
    };
    tool = new PinTool({ live, shown, notices: reporter } as unknown as Viewer);
  });

  it('keeps what was asked for before, whatever has been answered', async () => {
    for (const vertex of [5, 7, 3]) tap(vertex);
    await server.answer();
    await server.answer();
    // The answers came, but not yet what they changed.
    tap(9);
    await server.answer();
    expect(asked()).toEqual([
      ['sheets/a', 3, 5],
      ['sheets/a', 5, 7],
      ['sheets/a', 5, 7, 9],
    ]);
    expect(notices).toEqual(['Vertex 5 pinned (2 pinned)', 'Vertex 3 released (2 pinned)', 'Vertex 9 pinned (3 pinned)']);
  });

  it('begins with what the server has once that is told', async () => {
    tap(5);
    await server.answer(503);
    told();
    await Promise.resolve();
    tap(7);
    await server.answer();
    expect(asked()).toEqual([
      ['sheets/a', 3, 5],
      ['sheets/a', 3, 7],
    ]);
  });

  it('pins on each sheet what was tapped there, and on none whose pins are not known yet', async () => {
    tap(5);
    live.sheetName = 'sheets/b';
    shown.sheet = undefined;
    tap(6);
    shown.sheet = { pinnedVertices: [1] };
    tap(7);
    await server.answer();
    await server.answer();
    expect(asked()).toEqual([
      ['sheets/a', 3, 5],
      ['sheets/b', 1, 7],
    ]);
  });
});
