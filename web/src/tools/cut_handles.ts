import { Vector2 } from 'three';

export interface Handle {
  /** Place on the overlay, CSS pixels; undefined hides a handle behind the camera. */
  px: Vector2 | undefined;
  text: string;
  isChosen: boolean;
}

export interface HandleEvents {
  /** Called with the index of a handle that is pressed. */
  onChosen(index: number): void;
  /** Called with the index of a dragged handle and its new place, CSS pixels on the overlay. */
  onMoved(index: number, px: Vector2): void;
  /** Called with the place of a tap beside a handle, which is meant for what is below. */
  onTapped?(px: Vector2): void;
}

// Radius of the disc that is seen, CSS pixels. The area that can be touched is larger.
const kDiscPx = 14;
// A press that moves less than this is a tap.
const kTapReachPx = 6;
// Discs stand at least this far from each other.
const kApartPx = 27;
const kRounds = 12;

/**
 * Moves places apart, so that discs there do not overlap. Those that are far enough stay where they are.
 * @param held  index of a place that stays; -1: none
 */
export function spread(places: readonly (Vector2 | undefined)[], held: number): (Vector2 | undefined)[] {
  const moved = places.map((place) => place?.clone());
  for (let round = 0; round < kRounds; ++round) {
    let isDone = true;
    moved.forEach((a, i) => {
      for (let k = i + 1; a && k < moved.length; ++k) {
        const b = moved[k];
        const apart = b ? a.distanceTo(b) : kApartPx;
        if (!b || apart >= kApartPx - 0.5) continue;
        isDone = false;
        const away = apart > 0 ? b.clone().sub(a).divideScalar(apart) : new Vector2(1, 0);
        const missing = kApartPx - apart;
        if (i !== held) a.addScaledVector(away, k === held ? -missing : -0.5 * missing);
        if (k !== held) b.addScaledVector(away, i === held ? missing : 0.5 * missing);
      }
    });
    if (isDone) break;
  }
  return moved;
}

/** Returns the index of the place nearest to a point; -1 without places. */
export function nearestPlace(places: readonly (Vector2 | undefined)[], point: Vector2): number {
  let [nearest, least] = [-1, Infinity];
  places.forEach((place, i) => {
    const distance = place?.distanceTo(point) ?? Infinity;
    if (distance < least) [nearest, least] = [i, distance];
  });
  return nearest;
}

/**
 * Shows the points of a drawing as elements over the canvas, which can be dragged. Those that would overlap stand beside
 * their points, with a line to each.
 */
export class CutHandles {
  private readonly elements: HTMLElement[] = [];
  private readonly stems: HTMLElement[] = [];
  // Places of the points and of their discs.
  private points: readonly (Vector2 | undefined)[] = [];
  private discs: readonly (Vector2 | undefined)[] = [];
  private held: { index: number; start: Vector2; offset: Vector2; isMoved: boolean; isBeside: boolean } | undefined;

  constructor(
    private readonly overlay: HTMLElement,
    private readonly events: HandleEvents,
  ) {}

  show(handles: readonly Handle[]): void {
    while (this.elements.length < handles.length) this.create();
    this.points = handles.map(({ px }) => px);
    this.discs = spread(this.points, this.held?.isMoved ? this.held.index : -1);
    this.elements.forEach((element, i) => {
      const handle = handles[i];
      const [point, disc] = [this.points[i], this.discs[i]];
      element.hidden = !disc;
      this.showStem(this.stems[i], point, disc);
      if (!disc) return;
      element.style.transform = `translate(${disc.x.toFixed(1)}px, ${disc.y.toFixed(1)}px)`;
      element.classList.toggle('chosen', handle.isChosen);
      if (element.textContent !== handle.text) element.textContent = handle.text;
    });
  }

  private showStem(stem: HTMLElement, point: Vector2 | undefined, disc: Vector2 | undefined): void {
    const length = point && disc ? point.distanceTo(disc) : 0;
    stem.hidden = length < 1;
    if (!point || !disc || stem.hidden) return;
    const angle = Math.atan2(disc.y - point.y, disc.x - point.x);
    stem.style.transform = `translate(${point.x.toFixed(1)}px, ${point.y.toFixed(1)}px) rotate(${angle.toFixed(3)}rad)`;
    stem.style.width = `${length.toFixed(1)}px`;
  }

  private placeOf(event: PointerEvent): Vector2 {
    const bounds = this.overlay.getBoundingClientRect();
    return new Vector2(event.clientX - bounds.left, event.clientY - bounds.top);
  }

  private create(): void {
    const [element, stem] = [document.createElement('div'), document.createElement('div')];
    element.className = 'handle';
    stem.className = 'handle-stem';
    for (const each of [element, stem]) each.setAttribute('aria-hidden', 'true');
    element.addEventListener('pointerdown', (event) => this.press(event, element));
    element.addEventListener('pointermove', (event) => {
      if (element.hasPointerCapture(event.pointerId)) this.drag(this.placeOf(event));
    });
    element.addEventListener('pointerup', (event) => this.release(this.placeOf(event)));
    element.addEventListener('pointercancel', () => (this.held = undefined));
    this.overlay.append(stem, element);
    this.elements.push(element);
    this.stems.push(stem);
  }

  private press(event: PointerEvent, element: HTMLElement): void {
    event.preventDefault();
    const start = this.placeOf(event);
    // The areas of two handles may overlap, and the upper one need not be the nearer one.
    const index = nearestPlace(this.discs, start);
    const [point, disc] = [this.points[index], this.discs[index]];
    if (!point || !disc) return;
    element.setPointerCapture(event.pointerId);
    const isBeside = this.events.onTapped !== undefined && disc.distanceTo(start) > kDiscPx;
    this.held = { index, start, offset: point.clone().sub(start), isMoved: false, isBeside };
    if (!isBeside) this.events.onChosen(index);
  }

  private drag(px: Vector2): void {
    const { held } = this;
    if (!held || (!held.isMoved && px.distanceTo(held.start) < kTapReachPx)) return;
    if (!held.isMoved && held.isBeside) this.events.onChosen(held.index);
    held.isMoved = true;
    this.events.onMoved(held.index, px.clone().add(held.offset));
  }

  private release(px: Vector2): void {
    const { held } = this;
    this.held = undefined;
    if (held?.isBeside && !held.isMoved) this.events.onTapped?.(px);
  }
}
