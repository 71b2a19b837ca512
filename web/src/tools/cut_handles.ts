import { Vector2 } from 'three';

/** The numbered control points of a curve as elements over the canvas, which can be dragged. */
export class CutHandles {
  private readonly elements: HTMLElement[] = [];

  /** @param moved  called with the index of a handle and where it was dragged, CSS pixels on the overlay */
  constructor(
    private readonly overlay: HTMLElement,
    private readonly moved: (index: number, px: Vector2) => void,
  ) {}

  /** One handle a point; undefined hides that one (behind the camera). */
  show(points: readonly (Vector2 | undefined)[]): void {
    while (this.elements.length < points.length) this.elements.push(this.create(this.elements.length));
    this.elements.forEach((element, i) => {
      const point = points[i];
      element.hidden = !point;
      if (point) element.style.transform = `translate(${point.x.toFixed(1)}px, ${point.y.toFixed(1)}px)`;
    });
  }

  private create(index: number): HTMLElement {
    const element = document.createElement('div');
    element.className = 'handle';
    element.textContent = String(index + 1);
    element.setAttribute('aria-hidden', 'true');
    element.addEventListener('pointerdown', (event) => {
      event.preventDefault();
      element.setPointerCapture(event.pointerId);
    });
    element.addEventListener('pointermove', (event) => {
      if (!element.hasPointerCapture(event.pointerId)) return;
      const bounds = this.overlay.getBoundingClientRect();
      this.moved(index, new Vector2(event.clientX - bounds.left, event.clientY - bounds.top));
    });
    this.overlay.append(element);
    return element;
  }
}
