import type { MessageInitShape } from '@bufbuild/protobuf';
import { call } from '../../api';
import { InteractionService } from '../../gen/kerf/v1/interaction_pb';
import type { Vec3 } from '../../gen/kerf/v1/geometry_pb';
import type { Wind, WindSchema } from '../../gen/kerf/v1/scene_pb';
import type { Sheet } from '../../gen/kerf/v1/sheets_pb';
import { Newest } from '../../newest';
import type { Reporter } from '../../notifier';
import type { OpenSheet } from '../../sheet/open_sheet';
import { element, setText } from '../dom';

/**
 * A wind as shown by the sliders. azimuthDeg: direction from x to y, degrees, 0..360; risingDeg: angle above the
 * horizon, degrees.
 */
export interface WindSetting {
  azimuthDeg: number;
  risingDeg: number;
  speedMps: number;
}

const kDegree = Math.PI / 180;
// A slower wind counts as still air.
const kStillMps = 1e-9;

export function windVelocity({ azimuthDeg, risingDeg, speedMps }: WindSetting): { x: number; y: number; z: number } {
  const level = speedMps * Math.cos(risingDeg * kDegree);
  return {
    x: level * Math.cos(azimuthDeg * kDegree),
    y: level * Math.sin(azimuthDeg * kDegree),
    z: speedMps * Math.sin(risingDeg * kDegree),
  };
}

/** Inverts windVelocity(); still air keeps the direction of `before`. */
export function windSetting({ x, y, z }: Pick<Vec3, 'x' | 'y' | 'z'>, before: WindSetting): WindSetting {
  const speedMps = Math.hypot(x, y, z);
  if (speedMps < kStillMps) return { ...before, speedMps: 0 };
  return {
    azimuthDeg: (Math.atan2(y, x) / kDegree + 360) % 360,
    risingDeg: Math.asin(z / speedMps) / kDegree,
    speedMps,
  };
}

/** Controls air and wind; without air the sheet has no drag. */
export class WindControl {
  private readonly isOn = element<HTMLInputElement>('wind-on');
  private readonly speed = element<HTMLInputElement>('wind-speed');
  private readonly azimuth = element<HTMLInputElement>('wind-azimuth');
  private readonly rising = element<HTMLInputElement>('wind-rising');
  private readonly newest: Newest<MessageInitShape<typeof WindSchema> | undefined>;
  // Density and drag of the scene, which the control keeps.
  private air: Pick<Wind, 'airDensityKgpm3' | 'dragCoefficient'> | undefined;

  constructor(live: OpenSheet, reporter: Reporter) {
    this.newest = new Newest(
      (name, wind) =>
        reporter.attempt(() => call(InteractionService.method.setSheetWind, { name, setWind: { wind } })),
      () => live.refresh(),
    );
    for (const input of [this.isOn, this.speed, this.azimuth, this.rising]) {
      input.addEventListener('input', () => {
        // Turns air on, because a wind needs it.
        if (input !== this.isOn) this.isOn.checked = true;
        this.showValues();
        this.newest.put(live.sheetName, this.wind());
      });
    }
  }

  show({ scene }: Sheet): void {
    if (this.newest.isBusy) return;
    const wind = scene?.wind;
    this.isOn.checked = wind !== undefined;
    if (wind) {
      this.air = { airDensityKgpm3: wind.airDensityKgpm3, dragCoefficient: wind.dragCoefficient };
      const setting = windSetting(wind.velocityMps ?? { x: 0, y: 0, z: 0 }, this.setting);
      this.speed.value = String(setting.speedMps);
      this.azimuth.value = String(setting.azimuthDeg);
      this.rising.value = String(setting.risingDeg);
    }
    this.showValues();
  }

  private get setting(): WindSetting {
    return {
      azimuthDeg: this.azimuth.valueAsNumber,
      risingDeg: this.rising.valueAsNumber,
      speedMps: this.speed.valueAsNumber,
    };
  }

  private wind(): MessageInitShape<typeof WindSchema> | undefined {
    return this.isOn.checked ? { ...this.air, velocityMps: windVelocity(this.setting) } : undefined;
  }

  private showValues(): void {
    const { azimuthDeg, risingDeg, speedMps } = this.setting;
    const text = this.isOn.checked ? `${speedMps.toFixed(1)} m/s` : 'no air';
    setText(element('wind-speed-value'), text);
    setText(element('wind-azimuth-value'), `${azimuthDeg.toFixed(0)}°`);
    setText(element('wind-rising-value'), `${risingDeg.toFixed(0)}°`);
  }
}
