import { Vector2 } from 'three';

export interface Handle {
  /** Place on the overlay, CSS pixels; undefined hides a handle behind the camera. */
  px: Vector2 | undefined;
  text: string;
  isChosen: boolean;
}

/** Shows the points of a drawing as elements over the canvas, which can be dragged. */
export class CutHandles {
  private readonly elements: HTMLElement[] = [];

  /**
   * @param chosen  called with the index of a handle that is pressed
   * @param moved   called with the index of a dragged handle and its new place, CSS pixels on the overlay
   */
  constructor(
    private readonly overlay: HTMLElement,
    private readonly chosen: (index: number) => void,
    private readonly moved: (index: number, px: Vector2) => void,
  ) {}

  show(handles: readonly Handle[]): void {
    while (this.elements.length < handles.length) this.elements.push(this.create(this.elements.length));
    this.elements.forEach((element, i) => {
      const handle = handles[i];
      element.hidden = !handle?.px;
      if (!handle?.px) return;
      element.style.transform = `translate(${handle.px.x.toFixed(1)}px, ${handle.px.y.toFixed(1)}px)`;
      element.classList.toggle('chosen', handle.isChosen);
      if (element.textContent !== handle.text) element.textContent = handle.text;
    });
  }

  private create(index: number): HTMLElement {
    const element = document.createElement('div');
    element.className = 'handle';
    element.setAttribute('aria-hidden', 'true');
    element.addEventListener('pointerdown', (event) => {
      event.preventDefault();
      element.setPointerCapture(event.pointerId);
      this.chosen(index);
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
