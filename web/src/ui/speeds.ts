// The speeds offered; kerf.v1.SetSheetSpeedRequest.speed may be 0.01..4.
export const kSpeeds: readonly number[] = [1 / 64, 1 / 32, 1 / 16, 1 / 8, 1 / 4, 1 / 2, 1, 2, 4];

/** Formats a speed, simulated seconds per second of wall time: "1/4 ×", "2 ×", "0.2 ×". */
export function speedText(speed: number): string {
  const part = 1 / speed;
  const isPart = part > 1 && Math.abs(part - Math.round(part)) < 1e-9 && kSpeeds.includes(speed);
  return isPart ? `1/${Math.round(part)} ×` : `${Number(speed.toPrecision(3))} ×`;
}

/** Returns the next of kSpeeds, up (1) or down (-1); at an end of the list, that end. */
export function nextSpeed(speed: number, direction: 1 | -1): number {
  const beyond = kSpeeds.filter((other) => (direction > 0 ? other > speed : other < speed));
  return (direction > 0 ? beyond.at(0) : beyond.at(-1)) ?? Math.min(kSpeeds.at(-1)!, Math.max(kSpeeds[0], speed));
}

/** Returns the speed in stats of the server; 1 for old recordings, which have 0 there. */
export function speedOf({ speed }: { speed: number }): number {
  return speed > 0 ? speed : 1;
}
