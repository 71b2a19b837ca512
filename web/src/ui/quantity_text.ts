const kPrefixes: readonly [factor: number, prefix: string][] = [
  [1e9, 'G'],
  [1e6, 'M'],
  [1e3, 'k'],
  [1, ''],
  [1e-3, 'm'],
  [1e-6, 'µ'],
  [1e-9, 'n'],
];

// Formats a number with three digits; very small ones as a power of ten.
function digitsOf(value: number): string {
  const rounded = Number(value.toPrecision(3));
  return Math.abs(rounded) >= 1e-3 || rounded === 0 ? rounded.toLocaleString('en') : String(rounded);
}

/** Formats a number with three digits and a prefix of its unit: 1.5e5 Pa is "150 kPa". */
export function siText(value: number, unit: string): string {
  if (value === 0) return `0 ${unit}`;
  const [factor, prefix] = kPrefixes.find(([scale]) => Math.abs(value) >= scale * 0.9995) ?? kPrefixes.at(-1)!;
  return `${digitsOf(value / factor)} ${prefix}${unit}`;
}

/** Formats a number with three digits and its unit, if any, without a prefix. */
export function plainText(value: number, unit: string): string {
  return `${digitsOf(value)}${unit === '' || unit === '°' ? unit : ` ${unit}`}`;
}

// Accepts commas only between groups of three digits, as in "1,300"; any other could be a decimal comma.
const kNumber = /^\s*([+-]?(?:\d{1,3}(?:,\d{3})+|\d+)?(?:\.\d*)?(?:e[+-]?\d+)?)\s*(.*)$/i;

// Normalises a typed unit: "u" for "µ", "^3" and "3" for "³".
function normalised(unit: string): string {
  return unit.replace(/\s/g, '').replace(/μ|^u/, 'µ').replace('^', '').replace(/3$/, '³');
}

/**
 * Reads texts of siText() and plainText(), and typed ones: "150 kPa", "150k", "1.5e5". Undefined if the text is no
 * number or has another unit.
 * @param isSi  true if the unit takes prefixes
 */
export function parseQuantity(text: string, unit: string, isSi: boolean): number | undefined {
  const [, digits, rest] = kNumber.exec(text) ?? [];
  if (!digits || !/\d/.test(digits)) return undefined;
  const value = Number(digits.replaceAll(',', ''));
  if (!Number.isFinite(value)) return undefined;
  const given = normalised(rest);
  const own = normalised(unit);
  if (given === '' || given === own) return value;
  if (!isSi) return undefined;
  const prefix = given.endsWith(own) ? given.slice(0, given.length - own.length) : given;
  const factor = kPrefixes.find(([, name]) => name !== '' && name === prefix)?.[0];
  // Divides by the reciprocal of a small prefix, because the reciprocal is exact.
  return factor === undefined ? undefined : factor < 1 ? value / Math.round(1 / factor) : value * factor;
}
