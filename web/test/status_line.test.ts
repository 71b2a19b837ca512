import { create } from '@bufbuild/protobuf';
import { afterEach, describe, expect, it, vi } from 'vitest';
import { FrameStatsSchema } from '../src/gen/kerf/v1/stream_pb';
import { StatusLine } from '../src/ui/status_line';

describe('StatusLine', () => {
  afterEach(() => vi.unstubAllGlobals());

  it('says what the sheet does, and nothing where there is none any more', () => {
    const page: Record<string, { textContent: string; dataset: { level?: string } }> = {};
    vi.stubGlobal('document', {
      getElementById: (id: string) => (page[id] ??= { textContent: '', dataset: {} }),
    });
    const said = () => ['tick', 'vertices', 'pieces', 'rtf', 'age'].map((id) => page[`status-${id}`].textContent);
    const status = new StatusLine();
    const stats = create(FrameStatsSchema, { realTimeFactor: 0.5 });
    status.update({ tick: 1234, numVertices: 2500, numPieces: 3, stats }, 17, 0);
    expect(said()).toEqual(['1,234', '2,500', '3', '0.50 ×', '17 ms']);
    expect(page['status-rtf'].dataset.level).toBe('warn');
    status.update(undefined, 17, 0);
    expect(said()).toEqual(['–', '–', '–', '–', '–']);
    expect(page['status-rtf'].dataset.level).toBe('');
  });

  it('shows how many triangles pass through each other, if any do', () => {
    const page: Record<string, { textContent: string; dataset: object; hidden?: boolean }> = {};
    vi.stubGlobal('document', { getElementById: (id: string) => (page[id] ??= { textContent: '', dataset: {} }) });
    const status = new StatusLine();
    const update = (stats: object) => {
      status.update({ tick: 1, numVertices: 4, numPieces: 1, stats: create(FrameStatsSchema, stats) }, 17, 0);
    };
    update({ intersections: 1063n });
    expect(page['status-intersecting'].hidden).toBe(false);
    expect(page['status-intersections'].textContent).toBe('1,063');
    update({});
    expect(page['status-intersecting'].hidden).toBe(true);
    status.update(undefined, 17, 0);
    expect(page['status-intersecting'].hidden).toBe(true);
  });

  it('says how long changes wait to be stored, while some do', () => {
    const page: Record<string, { textContent: string; dataset: object; hidden?: boolean }> = {};
    vi.stubGlobal('document', { getElementById: (id: string) => (page[id] ??= { textContent: '', dataset: {} }) });
    const status = new StatusLine();
    const update = (stats: object) => {
      status.update({ tick: 1, numVertices: 4, numPieces: 1, stats: create(FrameStatsSchema, stats) }, 17, 0);
    };
    update({ unconfirmedMs: 1250 });
    expect(page['status-unconfirmed'].hidden).toBe(false);
    expect(page['status-unconfirmed-time'].textContent).toBe('1.3 s');
    update({});
    expect(page['status-unconfirmed'].hidden).toBe(true);
  });

  it('says in words that the sheet does not move, and how often its view is drawn', () => {
    const page: Record<string, { textContent: string; dataset: object }> = {};
    vi.stubGlobal('document', { getElementById: (id: string) => (page[id] ??= { textContent: '', dataset: {} }) });
    const said = () => ['rtf', 'age', 'fps'].map((id) => page[`status-${id}`].textContent);
    const status = new StatusLine();
    const figures = (stats: object) => {
      return { tick: 1, numVertices: 4, numPieces: 1, stats: create(FrameStatsSchema, stats) };
    };
    status.update(figures({ paused: true }), undefined, 5000);
    expect(said()).toEqual(['paused', 'current', 'paused']);
    status.update(figures({ sleeping: true }), undefined, 5000);
    expect(said()).toEqual(['at rest', 'current', 'at rest']);
    status.drawn(5000);
    status.update(figures({ sleeping: true }), undefined, 5000);
    expect(said()).toEqual(['at rest', 'current', '1']);
    status.update(figures({ realTimeFactor: 1 }), undefined, 9000);
    expect(said()).toEqual(['1.00 ×', '–', '0']);
  });
});
