import type { Vector2 } from 'three';

export interface PixelLine {
  /** Points on the canvas, CSS pixels; undefined behind the camera. */
  points: readonly (Vector2 | undefined)[];
  isGuide?: boolean;
}

/** A polygon on the canvas, CSS pixels; points behind the camera are undefined. */
export type PixelPolygon = readonly (Vector2 | undefined)[];

// More lines than this are drawn thinner.
const kManyLines = 12;

const kSvg = 'http://www.w3.org/2000/svg';

/**
 * Shows over the sheet the curve about to be cut, the strip that the cut removes and, thinner and white, guides. Lines
 * are bright in a dark rim, which is visible on any colour.
 */
export class CutPreview {
  private readonly svg = document.createElementNS(kSvg, 'svg');
  private readonly strip: SVGPathElement;
  private readonly guides: SVGPathElement[];
  private readonly curves: SVGPathElement[];

  constructor(overlay: HTMLElement) {
    const { svg } = this;
    svg.id = 'cut-preview';
    svg.setAttribute('aria-hidden', 'true');
    const paths = ['strip', 'guide-rim', 'guide', 'curve-rim', 'curve'].map((name) => {
      const path = document.createElementNS(kSvg, 'path');
      path.setAttribute('class', name);
      svg.append(path);
      return path;
    });
    this.strip = paths[0];
    this.guides = paths.slice(1, 3);
    this.curves = paths.slice(3);
    overlay.append(svg);
  }

  /**
   * @param dashPx  lengths cut and left in turn, CSS pixels; empty: everything is cut
   * @param strip   polygons of the strip that the cut removes, which may overlap
   */
  show(lines: readonly PixelLine[], dashPx: readonly number[] = [], strip: readonly PixelPolygon[] = []): void {
    this.strip.setAttribute('d', polygonData(strip));
    this.svg.classList.toggle('fine', lines.length > kManyLines);
    const guide = pathData(lines.filter((line) => line.isGuide));
    for (const path of this.guides) path.setAttribute('d', guide);
    const curve = pathData(lines.filter((line) => !line.isGuide));
    for (const path of this.curves) {
      path.setAttribute('d', curve);
      path.style.strokeDasharray = dashPx.join(' ');
      path.style.strokeLinecap = dashPx.length > 0 ? 'butt' : '';
    }
  }
}

// Leaves out polygons that are partly behind the camera.
function polygonData(polygons: readonly PixelPolygon[]): string {
  return polygons
    .filter((polygon) => polygon.every((point) => point !== undefined))
    .map((polygon) => `${pathData([{ points: polygon }])}Z`)
    .join('');
}

function pathData(lines: readonly PixelLine[]): string {
  let data = '';
  for (const { points } of lines) {
    let isJoined = false;
    for (const point of points) {
      if (point) data += `${isJoined ? 'L' : 'M'}${point.x.toFixed(1)} ${point.y.toFixed(1)}`;
      isJoined = point !== undefined;
    }
  }
  return data;
}
