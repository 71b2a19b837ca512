import { webcrypto } from 'node:crypto';
import { PerspectiveCamera, Scene, Vector3 } from 'three';
import type { Ray } from 'three';
import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import type { Rejection } from '../src/gen/kerf/v1/stream_pb';
import { GrabTool } from '../src/tools/grab_tool';
import type { Viewer } from '../src/tools/tool';

// Node 18 has none that is global.
if (!globalThis.crypto) Object.assign(globalThis, { crypto: webcrypto });

interface Sent {
  case: string;
  value: { grabId: string };
}

describe('GrabTool', () => {
  let sent: Sent[];
  let notices: string[];
  let live: { watch: object };
  let tool: GrabTool;
  let isTaken = false;
  // Vertices whose positions were asked for.
  let asked: number[];

  const connection = () => ({ state: 'live', send: (kind: Sent) => sent.push(kind) > 0 });
  const pointer = { ray: { intersectPlane: (_: unknown, at: Vector3) => at.set(0, 0, 2) } as unknown as Ray };
  const reject = (reason: string) =>
    tool.rejected({ grabId: sent[0].value.grabId, reason, message: `it is ${reason}` } as Rejection);
  const kinds = () => sent.map((request) => request.case);
  const grabIds = () => new Set(sent.map((request) => request.value.grabId));

  /** Pulls at a vertex and holds it. */
  function hold(): void {
    expect(tool.press(pointer as never)).toBe(true);
    tool.drag(pointer as never);
    tool.update();
  }

  function pull(): void {
    hold();
    tool.release();
  }

  /** The number of releases that were sent, a second after these refusals. */
  function releasesAfter(...refusals: string[]): number {
    refusals.forEach(reject);
    vi.advanceTimersByTime(1000);
    return kinds().filter((kind) => kind === 'release').length;
  }

  beforeEach(() => {
    vi.useFakeTimers();
    sent = [];
    notices = [];
    asked = [];
    const surface = {
      pick: () => ({ vertex: 7 }),
      vertexPosition: (vertex: number) => {
        asked.push(vertex);
        return new Vector3();
      },
      nearestWithMaterial: (vertex: number) => (isTaken ? 5 : vertex),
      mirror: { numVertices: 9 },
      locator: { min: { x: 0, y: 0 }, max: { x: 1, y: 1 } },
    };
    const stage = { scene: new Scene(), camera: new PerspectiveCamera(), invalidate: () => {} };
    live = { watch: connection() };
    const viewer = { stage, shown: { surface }, live, notices: { notify: (_: string, text: string) => notices.push(text) } };
    tool = new GrabTool(viewer as unknown as Viewer);
  });

  afterEach(() => {
    vi.useRealTimers();
  });

  it('sends a grab, its drag and its release', () => {
    pull();
    vi.advanceTimersByTime(5000);
    expect(kinds()).toEqual(['grab', 'drag', 'release']);
    expect(grabIds().size).toBe(1);
  });

  it('releases again, until it is taken, when the queue was full', () => {
    pull();
    for (let refusals = 1; refusals <= 3; ++refusals) expect(releasesAfter('QUEUE_FULL')).toBe(1 + refusals);
    vi.advanceTimersByTime(5000);
    expect(releasesAfter()).toBe(4);
    expect(grabIds().size).toBe(1);
    expect(notices).toEqual([]);
  });

  it('releases once more when drag and release were both refused, and minds no grab that is gone', () => {
    pull();
    expect(releasesAfter('QUEUE_FULL', 'QUEUE_FULL')).toBe(2);
    expect(releasesAfter('GRAB_NOT_FOUND')).toBe(2);
    expect(notices).toEqual([]);
  });

  it('leaves a release alone whose stream has ended', () => {
    pull();
    reject('QUEUE_FULL');
    live.watch = connection();
    expect(releasesAfter()).toBe(1);
  });

  it('goes on pulling, with its target sent anew, when a drag met a full queue', () => {
    hold();
    reject('QUEUE_FULL');
    tool.update();
    tool.update();
    tool.release();
    expect(kinds()).toEqual(['grab', 'drag', 'drag', 'release']);
  });

  it('holds one vertex at a time', () => {
    hold();
    hold();
    tool.release();
    expect(kinds()).toEqual(['grab', 'drag', 'release', 'grab', 'drag', 'release']);
    const ids = sent.map((request) => request.value.grabId);
    expect(ids.slice(0, 3)).toEqual(Array(3).fill(ids[0]));
    expect(ids.slice(3)).toEqual(Array(3).fill(ids[5]));
    expect(ids[5]).not.toBe(ids[0]);
  });

  it('is shown beside its vertex while that has no material', () => {
    hold();
    isTaken = true;
    tool.update();
    isTaken = false;
    tool.update();
    expect(asked.slice(-3)).toEqual([7, 5, 7]);
    expect(kinds()).toEqual(['grab', 'drag']);
  });

  it('tells another refusal and ends the pull', () => {
    tool.press(pointer as never);
    reject('TOO_MANY_GRABS');
    expect(notices).toEqual(['The server refused the pull: it is TOO_MANY_GRABS']);
    tool.drag(pointer as never);
    tool.release();
    expect(kinds()).toEqual(['grab']);
  });
});
