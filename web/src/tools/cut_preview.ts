import type { Vector2 } from 'three';

export interface PixelLine {
  /** Undefined behind the camera. */
  points: readonly (Vector2 | undefined)[];
  isGuide?: boolean;
}

/** A polygon on the canvas; undefined behind the camera. */
export type PixelPolygon = readonly (Vector2 | undefined)[];

// So many lines are drawn thinner.
const kManyLines = 12;

const kSvg = 'http://www.w3.org/2000/svg';

/**
 * The curve about to be cut, the strip that it takes away and, thinner and white, its guides, over the sheet: a bright
 * line in a dark rim reads everywhere.
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
   * @param dashPx  lengths that are cut and left, CSS pixels; none: all of it is cut
   * @param strip   what is taken away: polygons that may overlap
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

// One that is partly behind the camera is left out.
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
