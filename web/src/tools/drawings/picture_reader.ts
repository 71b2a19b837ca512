import { call } from '../../api';
import { FileService } from '../../gen/kerf/v1/files_pb';
import type { DrawingReport } from '../../gen/kerf/v1/files_pb';
import { inUnitBox, svgOutline } from '../../geometry/svg_outline';
import type { DrawingContent } from './drawing_content';
import type { Picture } from './picture_drawing';

const kMillimetres = 1000;
// Names of each kind that a text lists.
const kMaxNames = 6;

/** Asks the server what is in a drawing, of the shapes that `only` names; empty: all. Throws ApiError. */
export async function readPicture(name: string, content: DrawingContent, only = ''): Promise<Picture> {
  const value = { ...content.value, reading: { only: only ? [only] : [] } };
  const report = await call(FileService.method.inspectDrawing, { drawing: { case: content.case, value } as never });
  return { name, content, only, report, outline: outlineOf(report, content) };
}

// Lines of the report are upright; the box of an outline has y down, as pictures have.
function outlineOf(report: DrawingReport, content: DrawingContent): Picture['outline'] {
  const lines = report.preview.map(({ points }) => points.map(({ x, y }) => ({ x, y: -y })));
  if (lines.length > 0) return inUnitBox(lines);
  return content.case === 'svg' ? svgOutline(content.value.text) : undefined;
}

/** Says in a sentence or two what a drawing has: its size, layers, colours and ends that nearly meet. */
export function reportText(report: DrawingReport): string {
  const [width, height] = [report.max!.x - report.min!.x, report.max!.y - report.min!.y].map(millimetres);
  const parts = [`${width} x ${height} mm, ${report.lines} ${report.lines === 1 ? 'line' : 'lines'}`];
  for (const [kind, prefix] of [['layers', 'layer='], ['colours', 'stroke='], ['fills', 'fill=']]) {
    const names = report.groups.filter(({ selector }) => selector.startsWith(prefix)).map(({ selector }) => selector.slice(prefix.length));
    if (names.length > 1) parts.push(`${kind} ${names.slice(0, kMaxNames).join(', ')}${names.length > kMaxNames ? ' ...' : ''}`);
  }
  const ends = report.nearEnds;
  if (ends > 0) parts.push(`${ends} ${ends === 1 ? 'end nearly meets' : 'ends nearly meet'} another line and will be joined`);
  return parts.join('; ');
}

function millimetres(metres: number): string {
  return String(Number((metres * kMillimetres).toPrecision(3)));
}
