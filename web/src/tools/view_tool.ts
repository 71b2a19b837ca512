import type { Tool } from './tool';

/** Takes no gesture, so that every gesture moves the view. */
export class ViewTool implements Tool {
  readonly id = 'view';
  readonly cursor = 'grab';
  enter(): void {}
  leave(): void {}
  press(): boolean {
    return false;
  }
  drag(): void {}
  release(): void {}
  abandon(): void {}
  tap(): void {}
  update(): void {}
}
