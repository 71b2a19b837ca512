import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import type { Quality } from '../src/scene/drawing_quality';
import { AdaptiveDrawing, slowDrawingText } from '../src/ui/adaptive_drawing';
import type { AdaptedParts } from '../src/ui/adaptive_drawing';

describe('slowDrawingText', () => {
  it('says where there is no graphics card', () => {
    for (const name of [
      'ANGLE (Google, Vulkan 1.3.0 (SwiftShader Device (Subzero) (0x0000C0DE)), SwiftShader driver)',
      'ANGLE (Mesa, llvmpipe (LLVM 15.0.6, 256 bits), OpenGL 4.5)',
      'Microsoft Basic Render Driver',
      'Apple Software Renderer',
    ]) {
      expect(slowDrawingText(name)).toBe('Drawing is slow without a graphics card.');
    }
    for (const name of ['ANGLE (NVIDIA, NVIDIA GeForce GTX 1650, OpenGL 4.5)', 'Mali-G78', '']) {
      expect(slowDrawingText(name)).toBe('Drawing is slow in this browser.');
    }
  });
});

describe('AdaptiveDrawing', () => {
  let page: EventTarget;
  let parts: AdaptedParts & { imageMode: { isOn: boolean } };
  let isMoving: boolean;
  let qualities: Quality[];
  const offer = vi.fn();
  const close = vi.fn();

  /** Turns of the loop, this far apart, of which each has something to draw. */
  const turns = (drawing: AdaptiveDrawing, count: number, everyMs: number, fromMs = 0) => {
    for (let i = 0; i < count; ++i) drawing.begin(fromMs + i * everyMs, true, isMoving);
  };

  beforeEach(() => {
    page = new EventTarget();
    vi.stubGlobal('document', page);
    vi.stubGlobal('location', { search: '' });
    qualities = [];
    isMoving = true;
    parts = {
      imageMode: { isOn: false, toggle: vi.fn() },
      live: { isWatched: true },
      notices: { offer: offer.mockReset().mockReturnValue(close) },
      stage: {
        graphics: 'llvmpipe',
        setQuality: (quality: Quality) => {
          const isOther = qualities.at(-1)?.scale !== quality.scale;
          qualities.push(quality);
          return isOther;
        },
      },
    };
  });
  afterEach(() => vi.unstubAllGlobals());

  it('offers the pictures of the server once, where the coarsest are too slow', () => {
    const drawing = new AdaptiveDrawing(parts);
    turns(drawing, 60, 200);
    expect(qualities.at(-1)).toEqual({ scale: 0.5, hasShadows: false });
    expect(offer).toHaveBeenCalledTimes(1);
    offer.mock.lastCall![2]();
    expect(parts.imageMode.toggle).toHaveBeenCalled();
    parts.imageMode.isOn = true;
    drawing.begin(12_000, false, isMoving);
    expect(close).toHaveBeenCalled();
    parts.imageMode.isOn = false;
    turns(drawing, 60, 200, 13_000);
    expect(offer).toHaveBeenCalledTimes(1);
  });

  it('draws a still picture once more, in full', () => {
    const drawing = new AdaptiveDrawing(parts);
    turns(drawing, 60, 200);
    isMoving = false;
    expect(drawing.begin(12_100, false, isMoving)).toBe(false);
    expect(drawing.begin(12_400, false, isMoving)).toBe(true);
    expect(qualities.at(-1)?.scale).toBe(1);
    expect(drawing.begin(13_000, false, isMoving)).toBe(false);
  });

  it('counts neither pauses between pictures nor what nobody sees', () => {
    const drawing = new AdaptiveDrawing(parts);
    for (let i = 0; i < 40; ++i) {
      drawing.begin(400 * i, true, isMoving);
      drawing.begin(400 * i + 16, false, isMoving);
    }
    for (let i = 0; i < 40; ++i) {
      drawing.begin(20_000 + 400 * i, true, isMoving);
      page.dispatchEvent(new Event('visibilitychange'));
    }
    expect(qualities.every(({ scale }) => scale === 1)).toBe(true);
  });

  it('leaves the resolution alone where the address asks for it', () => {
    vi.stubGlobal('location', { search: '?resolution=full' });
    turns(new AdaptiveDrawing(parts), 60, 200);
    expect(qualities).toEqual([]);
    expect(offer).not.toHaveBeenCalled();
  });
});
