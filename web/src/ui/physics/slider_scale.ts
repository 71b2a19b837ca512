/** Maps the places of a slider, whole numbers from 0, to values. */
export interface SliderScale {
  /** The last place. */
  readonly end: number;
  valueAt(place: number): number;
  /** Returns the nearest place; that of the nearer end for a value beyond the scale. */
  placeOf(value: number): number;
}

// An arrow key thus changes the value by 6 %.
const kPlacesPerDecade = 40;

function clamped(place: number, end: number): number {
  return Math.min(end, Math.max(0, Math.round(place)));
}

/** @param step  difference of the values of neighbouring places */
export function linearScale(min: number, max: number, step: number): SliderScale {
  const end = Math.round((max - min) / step);
  // Rounds to a readable number: 0.3, not 0.30000000000000004.
  const valueAt = (place: number) => Number((min + place * step).toPrecision(12));
  return { end, valueAt, placeOf: (value) => clamped((value - min) / step, end) };
}

/**
 * Makes a scale on which the values of neighbouring places have a constant ratio.
 * @param hasZero  adds a first place with the value 0, before `min`
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
