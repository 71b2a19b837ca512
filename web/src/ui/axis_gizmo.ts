import { Quaternion, Vector3 } from 'three';
import type { Stage } from '../scene/stage';
import { element } from './dom';

/** An end of an axis on the gizmo. */
export interface AxisPlace {
  /** Offset from the middle, CSS pixels, y down. */
  x: number;
  y: number;
  /** Towards the viewer, -1..1. */
  depth: number;
}

// Distance of the balls from the middle, CSS pixels.
const kReachPx = 27;

/** Directions from which the gizmo looks at the sheet, by the name of its buttons. */
export const kSides: Readonly<Record<string, Vector3>> = {
  '+x': new Vector3(1, 0, 0),
  '-x': new Vector3(-1, 0, 0),
  '+y': new Vector3(0, 1, 0),
  '-y': new Vector3(0, -1, 0),
  '+z': new Vector3(0, 0, 1),
  '-z': new Vector3(0, 0, -1),
};

/** Returns the place of an axis' end as a camera with this orientation sees it. */
export function axisPlace(axis: Vector3, camera: Quaternion): AxisPlace {
  const seen = axis.clone().applyQuaternion(camera.clone().invert());
  return { x: kReachPx * seen.x, y: -kReachPx * seen.y, depth: seen.z };
}

/** Shows how the axes of the world lie in the picture; a press on one looks along it. */
export class AxisGizmo {
  private readonly buttons = new Map<string, HTMLButtonElement>();
  private readonly lines = new Map<string, SVGLineElement>();
  private readonly shown = new Quaternion(0, 0, 0, 0);

  constructor(private readonly stage: Pick<Stage, 'camera' | 'lookFrom' | 'place'>) {
    const gizmo = element('axes');
    for (const button of gizmo.querySelectorAll<HTMLButtonElement>('[data-side]')) {
      this.buttons.set(button.dataset.side!, button);
      button.addEventListener('click', () => this.stage.lookFrom(kSides[button.dataset.side!]));
    }
    for (const line of gizmo.querySelectorAll<SVGLineElement>('[data-axis]')) this.lines.set(line.dataset.axis!, line);
  }

  /** Looks from one side or, if the camera is there already, from the opposite one. */
  toggle(side: string, opposite: string): void {
    const { eye, target } = this.stage.place;
    const isThere = eye.sub(target).angleTo(kSides[side]) < 0.02;
    this.stage.lookFrom(kSides[isThere ? opposite : side]);
  }

  /** Turns the axes with the camera. Call it before each drawing. */
  update(): void {
    const { quaternion } = this.stage.camera;
    if (this.shown.equals(quaternion)) return;
    this.shown.copy(quaternion);
    for (const [side, button] of this.buttons) {
      const { x, y, depth } = axisPlace(kSides[side], quaternion);
      button.style.transform = `translate(${x.toFixed(1)}px, ${y.toFixed(1)}px)`;
      button.style.zIndex = String(Math.round(10 * (depth + 1)));
      const line = this.lines.get(side);
      line?.setAttribute('x2', x.toFixed(1));
      line?.setAttribute('y2', y.toFixed(1));
    }
  }
}
