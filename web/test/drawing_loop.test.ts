import { beforeEach, describe, expect, it, vi } from 'vitest';
import { DrawingLoop } from '../src/ui/drawing_loop';
import type { DrawnParts } from '../src/ui/drawing_loop';

describe('DrawingLoop', () => {
  let frame: (nowMs: number) => void;
  let loop: DrawingLoop;
  const stats = { paused: false, sleeping: false };
  const stage = { advance: vi.fn(), draw: vi.fn() };
  const shown = {
    surface: { mirror: { stats } },
    setHiding: vi.fn(),
    showAgain: vi.fn(),
    update: vi.fn(),
    drawn: vi.fn(),
  };
  const live = {
    watch: { state: 'live' } as { state: string } | undefined,
    ageMs: 7,
    acknowledge: vi.fn(),
    advance: vi.fn(),
    followPace: vi.fn(),
  };
  const replayBar = { advance: vi.fn(), playing: undefined as { isPlaying: boolean } | undefined };
  const imageMode = { isShown: false, ageMs: 30, format: 'VP8', figures: vi.fn(), look: vi.fn(), draw: vi.fn() };
  const quality = { begin: vi.fn() };
  const statistics = { drawn: vi.fn(), update: vi.fn() };
  const status = { drawn: vi.fn(), update: vi.fn() };
  const look = { color: vi.fn() };

  beforeEach(() => {
    vi.resetAllMocks();
    vi.stubGlobal('requestAnimationFrame', (next: typeof frame) => (frame = next));
    stats.paused = false;
    live.watch = { state: 'live' };
    replayBar.playing = undefined;
    imageMode.isShown = false;
    // Draws where the view has changed.
    quality.begin.mockImplementation((_: number, isChanged: boolean) => isChanged);
    const tools = { tool: { update: vi.fn() }, cut: { isOnSheet: false } };
    const pieces = { update: vi.fn() };
    const people = { place: vi.fn(), update: vi.fn() };
    const [cuts, plots, axes] = Array.from({ length: 3 }, () => ({ update: vi.fn() }));
    const parts = { stage, shown, live, replayBar, look, imageMode, tools, pieces, people, cuts, plots, axes, quality, status, statistics };
    loop = new DrawingLoop(parts as unknown as DrawnParts);
    loop.start();
  });

  it('draws nothing while nothing changes, and takes each frame once', () => {
    frame(0);
    expect([stage.draw.mock.calls.length, loop.framesDrawn]).toEqual([0, 0]);
    stage.advance.mockReturnValue(true);
    shown.update.mockReturnValueOnce(true);
    frame(16);
    frame(32);
    expect([stage.draw.mock.calls.length, loop.framesDrawn]).toEqual([2, 2]);
    expect([look.color.mock.calls.length, live.acknowledge.mock.calls.length]).toEqual([1, 1]);
  });

  it('shows again what has moved, live or in a recording', () => {
    live.advance.mockReturnValueOnce(true);
    frame(0);
    replayBar.advance.mockReturnValueOnce(true);
    frame(16);
    frame(32);
    expect(shown.showAgain).toHaveBeenCalledTimes(2);
  });

  it.each([
    ['a moving sheet', () => {}, 7, true],
    ['a paused sheet', () => (stats.paused = true), undefined, false],
    ['a sheet whose connection is lost', () => (live.watch!.state = 'lost'), undefined, false],
    ['a recording that plays', () => [live.watch, replayBar.playing] = [undefined, { isPlaying: true }], undefined, true],
    ['a picture of the server', () => (imageMode.isShown = true), 30, true],
  ])('tells the age of %s', (_, arrange, ageMs, isMoving) => {
    arrange();
    frame(16);
    expect(status.update).toHaveBeenLastCalledWith(imageMode.isShown ? undefined : { stats }, ageMs, 16);
    expect(quality.begin).toHaveBeenLastCalledWith(16, undefined, isMoving);
  });

  it('counts the age of a frame once, and pictures of the server in place of drawings', () => {
    stage.advance.mockReturnValue(true);
    shown.drawn.mockReturnValueOnce(true);
    frame(0);
    frame(16);
    expect(statistics.drawn.mock.calls).toEqual([[0, 7], [16, undefined]]);
    imageMode.isShown = true;
    frame(32);
    expect(loop.framesDrawn).toBe(2);
    imageMode.draw.mockReturnValueOnce(true);
    frame(48);
    expect([loop.framesDrawn, statistics.drawn.mock.lastCall]).toEqual([3, [48, 30]]);
  });
});
