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
});
