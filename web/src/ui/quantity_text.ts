const kPrefixes: readonly [factor: number, prefix: string][] = [
  [1e9, 'G'],
  [1e6, 'M'],
  [1e3, 'k'],
  [1, ''],
  [1e-3, 'm'],
  [1e-6, 'µ'],
  [1e-9, 'n'],
];

// To three digits; what digits after the point would hide is written as a power of ten.
function digitsOf(value: number): string {
  const rounded = Number(value.toPrecision(3));
  return Math.abs(rounded) >= 1e-3 || rounded === 0 ? rounded.toLocaleString('en') : String(rounded);
}

/** A number to three digits with a prefix of its unit: 1.5e5 Pa is "150 kPa". */
export function siText(value: number, unit: string): string {
  if (value === 0) return `0 ${unit}`;
  const [factor, prefix] = kPrefixes.find(([scale]) => Math.abs(value) >= scale * 0.9995) ?? kPrefixes.at(-1)!;
  return `${digitsOf(value / factor)} ${prefix}${unit}`;
}

/** A number to three digits and its unit as it is, if it has one. */
export function plainText(value: number, unit: string): string {
  return `${digitsOf(value)}${unit === '' || unit === '°' ? unit : ` ${unit}`}`;
}

// "1,300" is what these texts write; a comma anywhere else could be a decimal one.
const kNumber = /^\s*([+-]?(?:\d{1,3}(?:,\d{3})+|\d+)?(?:\.\d*)?(?:e[+-]?\d+)?)\s*(.*)$/i;

// As people type it where a keyboard has no better.
function normalised(unit: string): string {
  return unit.replace(/\s/g, '').replace(/μ|^u/, 'µ').replace('^', '').replace(/3$/, '³');
}

/**
 * Reads the texts of siText and plainText, and typed ones: "150 kPa", "150k", "1.5e5". Undefined if that is not a number, or
 * one of another unit.
 * @param isSi  the unit takes prefixes
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
  // By the reciprocal, which is exact where the prefix is a small one.
  return factor === undefined ? undefined : factor < 1 ? value / Math.round(1 / factor) : value * factor;
}
