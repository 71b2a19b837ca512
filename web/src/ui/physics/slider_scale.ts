/** Places of a slider, whole numbers from 0, and the values that they stand for. */
export interface SliderScale {
  /** The last place. */
  readonly end: number;
  valueAt(place: number): number;
  /** The nearest place; a value beyond the ends is at that end. */
  placeOf(value: number): number;
}

// An arrow key moves by 6 %.
const kPlacesPerDecade = 40;

function clamped(place: number, end: number): number {
  return Math.min(end, Math.max(0, Math.round(place)));
}

/** @param step  one place */
export function linearScale(min: number, max: number, step: number): SliderScale {
  const end = Math.round((max - min) / step);
  // Rounded to what can be read: 0.3, not 0.30000000000000004.
  const valueAt = (place: number) => Number((min + place * step).toPrecision(12));
  return { end, valueAt, placeOf: (value) => clamped((value - min) / step, end) };
}

/**
 * Each place a factor above the one before.
 * @param hasZero  the first place is 0 in place of `min`
 */
export function logScale(min: number, max: number, hasZero = false): SliderScale {
  const first = hasZero ? 1 : 0;
  const end = first + Math.round(kPlacesPerDecade * Math.log10(max / min));
  return {
    end,
    valueAt: (place) => (place < first ? 0 : Number((min * 10 ** ((place - first) / kPlacesPerDecade)).toPrecision(3))),
    placeOf: (value) => {
      if (!(value > 0)) return 0;
      return Math.max(first, clamped(first + kPlacesPerDecade * Math.log10(value / min), end));
    },
  };
}
