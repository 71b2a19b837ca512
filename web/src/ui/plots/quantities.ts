import { Probe_Quantity } from '../../gen/kerf/v1/analysis_pb';
import type { Point2 } from '../../geometry/locator';
import type { ProbeRequest } from '../../stream/watch';
import { plainText, siText } from '../quantity_text';

/** A quantity that can be plotted. */
export interface PlottedQuantity {
  readonly id: string;
  readonly label: string;
  /** True if it is measured at a point that the user chooses. */
  readonly isAtPoint: boolean;
  /** Unit of the values after `scale`. */
  readonly unit: string;
  /** Factor on the server's values. */
  readonly scale: number;
  readonly quantity: Probe_Quantity;
  /** Measured over the whole sheet as a region, not as its own whole. */
  readonly isOfRegion?: boolean;
}

const kWhole = { isAtPoint: false, scale: 1 };
const kAtPoint = { isAtPoint: true, scale: 1 };

export const kQuantities: readonly PlottedQuantity[] = [
  { ...kWhole, id: 'energy', label: 'Energy', unit: 'J', quantity: Probe_Quantity.ENERGY },
  { ...kWhole, id: 'reaction', label: 'Force at the pins', unit: 'N', quantity: Probe_Quantity.REACTION, isOfRegion: true },
  { ...kWhole, id: 'centre', label: 'Centre of mass', unit: 'm', quantity: Probe_Quantity.CENTRE_OF_MASS },
  { ...kWhole, id: 'size', label: 'Size of the box around it', unit: 'm', quantity: Probe_Quantity.EXTENT },
  { ...kWhole, id: 'momentum', label: 'Momentum', unit: 'kg m/s', quantity: Probe_Quantity.MOMENTUM },
  { ...kAtPoint, id: 'position', label: 'Position of a point', unit: 'm', quantity: Probe_Quantity.POSITION },
  { ...kAtPoint, id: 'displacement', label: 'Displacement of a point', unit: 'm', quantity: Probe_Quantity.DISPLACEMENT },
  { ...kAtPoint, id: 'velocity', label: 'Velocity of a point', unit: 'm/s', quantity: Probe_Quantity.VELOCITY },
  { ...kAtPoint, id: 'strain', label: 'Strain at a point', unit: '%', scale: 100, quantity: Probe_Quantity.STRAIN },
  { ...kAtPoint, id: 'stress', label: 'Stress at a point', unit: 'Pa', quantity: Probe_Quantity.STRESS },
  { ...kAtPoint, id: 'opening', label: 'Opening of a cut at a point', unit: 'm', quantity: Probe_Quantity.OPENING },
];

/**
 * Returns the probe that measures a quantity.
 * @param name   of its columns, see kerf.v1.Probe
 * @param point  material coordinates, metres, if the quantity is at a point
 */
export function probeOf({ quantity, isOfRegion }: PlottedQuantity, name: string, point: Point2 | undefined): ProbeRequest {
  const region = isOfRegion ? { region: { case: 'all' as const, value: true } } : undefined;
  return { name, quantity, points: point ? [point] : [], region };
}

/** Formats a value with three digits and its unit. */
export function valueText(value: number, unit: string): string {
  if (!Number.isFinite(value)) return '–';
  const isPlain = unit === '%' || unit.includes(' ');
  const text = isPlain ? plainText(value, unit) : siText(value, unit);
  return text.replace('-', '−');
}
