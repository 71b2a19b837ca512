import type { Stage } from '../scene/stage';
import type { LiveSheet } from '../sheet/live_sheet';
import type { ShownSheet } from '../sheet/shown_sheet';
import type { AdaptiveDrawing } from './adaptive_drawing';
import type { ImageMode } from './image_mode';
import { isStill } from './run_text';
import type { StatisticsPanel } from './statistics_panel';
import type { StatusLine } from './status_line';

/** The parts of the viewer that take part in a drawing. */
export interface DrawnParts {
  readonly stage: Pick<Stage, 'advance' | 'draw'>;
  readonly shown: Pick<ShownSheet, 'surface' | 'setHiding' | 'showAgain' | 'update' | 'drawn'>;
  readonly live: Pick<LiveSheet, 'watch' | 'ageMs' | 'acknowledge' | 'advance' | 'followPace'>;
  readonly replayBar: { advance(nowMs: number): boolean; readonly playing: { readonly isPlaying: boolean } | undefined };
  readonly look: { color(): void };
  readonly imageMode: Pick<ImageMode, 'isShown' | 'ageMs' | 'format' | 'figures' | 'look' | 'draw'>;
  readonly tools: { readonly tool: { update(): void }; readonly cut: { readonly isOnSheet: boolean } };
  readonly pieces: { update(): void };
  readonly cuts: { update(): void };
  readonly plots: { update(nowMs: number): void };
  readonly axes: { update(): void };
  readonly people: { place(): void; update(): void };
  readonly quality: Pick<AdaptiveDrawing, 'begin'>;
  readonly status: Pick<StatusLine, 'drawn' | 'update'>;
  readonly statistics: Pick<StatisticsPanel, 'drawn' | 'update'>;
}

/** Draws at each animation frame if anything has changed, and updates the figures about drawing. */
export class DrawingLoop {
  framesDrawn = 0;

  constructor(private readonly parts: DrawnParts) {}

  start(): void {
    requestAnimationFrame((nowMs) => this.turn(nowMs));
  }

  private turn(nowMs: number): void {
    this.start();
    const { stage, shown, live, replayBar, imageMode, tools, people, cuts, plots, axes, quality } = this.parts;
    live.followPace();
    if (live.advance(nowMs) || replayBar.advance(nowMs)) shown.showAgain();
    // Lets folds hide a drawing on the sheet also over a picture of the server.
    shown.setHiding(imageMode.isShown && tools.cut.isOnSheet);
    const isStale = quality.begin(nowMs, stage.advance(), this.isMoving);
    if (isStale) {
      this.takeFrame();
      tools.tool.update();
      people.place();
      axes.update();
      stage.draw();
      imageMode.look();
    }
    // While a picture of the server is shown, only that picture counts as a drawing of the sheet.
    const isDrawn = imageMode.draw() || (isStale && !imageMode.isShown);
    if (isDrawn) this.drawn(nowMs);
    this.showFigures(nowMs);
    people.update();
    cuts.update();
    plots.update(nowMs);
  }

  private takeFrame(): void {
    const { shown, look, live, pieces } = this.parts;
    if (!shown.update()) return;
    look.color();
    live.acknowledge();
    pieces.update();
  }

  private drawn(nowMs: number): void {
    const { shown, imageMode, status, statistics } = this.parts;
    this.framesDrawn += 1;
    status.drawn(nowMs);
    const isNew = shown.drawn() || imageMode.isShown;
    statistics.drawn(nowMs, isNew ? this.ageMs : undefined);
  }

  private showFigures(nowMs: number): void {
    const { shown, imageMode, status, statistics } = this.parts;
    const mesh = shown.surface?.mirror;
    const figures = mesh && imageMode.isShown ? imageMode.figures(mesh) : mesh;
    status.update(figures, this.ageMs, nowMs);
    statistics.update(figures, imageMode.isShown ? imageMode.format : 'mesh', nowMs);
  }

  // True if the shown sheet moves by itself.
  private get isMoving(): boolean {
    const { live, replayBar, shown } = this.parts;
    if (!live.watch) return replayBar.playing?.isPlaying ?? false;
    return live.watch.state === 'live' && !isStill(shown.surface?.mirror.stats);
  }

  // Undefined for a still sheet: it sends nothing, so its last frame is up to date.
  private get ageMs(): number | undefined {
    const { live, imageMode } = this.parts;
    if (imageMode.isShown) return imageMode.ageMs;
    return live.watch && this.isMoving ? live.ageMs : undefined;
  }
}
