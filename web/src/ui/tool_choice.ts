import { Scope } from '../gen/kerf/v1/access_service_pb';
import type { Point2 } from '../geometry/locator';
import { CutTool } from '../tools/cut_tool';
import { GrabTool } from '../tools/grab_tool';
import { KeyboardPointer } from '../tools/keyboard_pointer';
import { MeasureTool } from '../tools/measure_tool';
import { PickTool } from '../tools/pick_tool';
import { PinTool } from '../tools/pin_tool';
import { PointerRouter } from '../tools/pointer_router';
import type { Tool, ToolId, Viewer } from '../tools/tool';
import { ViewTool } from '../tools/view_tool';
import type { Rights } from './access/rights';
import { CutPanel } from './cut_panel';
import { Choice, element } from './dom';
import { DrawingOptions } from './drawing_options';
import { MeasurePanel } from './measure_panel';

export interface ToolChoiceEvents {
  /** Called when a tool was chosen. */
  onChosen(): void;
  /** Called when a tool that changes the sheet was chosen. */
  onTried(): void;
  /** Called with the name of a cut that the user made. */
  onCut(name: string): void;
  /** Called when the user wants a drawing from a file for the cut tool. */
  onFileWanted(): void;
}

/** The tools. One of them is chosen and gets the gestures of mouse, fingers and keys on the canvas. */
export class ToolChoice {
  readonly cut: CutTool;
  readonly grab: GrabTool;
  readonly measure: MeasureTool;
  readonly cutPanel: CutPanel;
  readonly keyboardPointer: KeyboardPointer;

  private readonly drawingOptions: DrawingOptions;
  private readonly canvas = element<HTMLCanvasElement>('canvas');
  private readonly tools: Record<ToolId, Tool>;
  private readonly buttons: Choice<ToolId>;
  private readonly picking: PickTool;
  private readonly measurePanel = new MeasurePanel();
  private chosen: Tool;
  private beforePick: ToolId = 'view';

  /** @param replayBar  says whether a recording is shown, which no tool can change */
  constructor(
    private readonly viewer: Viewer,
    private readonly replayBar: { readonly isOpen: boolean },
    private readonly rights: Pick<Rights, 'allows'>,
    private readonly events: ToolChoiceEvents,
  ) {
    this.cut = new CutTool(
      viewer,
      () => this.updateCutPanel(),
      (name) => events.onCut(name),
    );
    this.grab = new GrabTool(viewer);
    this.measure = new MeasureTool(viewer, (measured) => this.measurePanel.show(measured));
    this.picking = new PickTool(viewer, () => this.choose(this.beforePick));
    const [view, pin] = [new ViewTool(), new PinTool(viewer)];
    this.tools = { view, cut: this.cut, grab: this.grab, pin, measure: this.measure, pick: this.picking };
    this.chosen = this.tools.view;
    this.cutPanel = new CutPanel(
      this.cut,
      () => viewer.stage.focus(),
      () => events.onFileWanted(),
    );
    this.drawingOptions = new DrawingOptions(this.cut, viewer.notices, () => viewer.stage.focus());
    this.buttons = new Choice<ToolId>(element('tools'), 'tool', (id) => this.choose(id));
    this.keyboardPointer = new KeyboardPointer(viewer, () => this.chosen);
    new PointerRouter(
      element('stage'),
      this.canvas,
      viewer.stage,
      () => this.chosen,
      () => this.keyboardPointer.hide(),
    );
    this.chosen.enter();
    this.buttons.show('view');
    this.canvas.style.cursor = this.chosen.cursor;
  }

  get tool(): Tool {
    return this.chosen;
  }

  /** Lets the next tap choose a point of the sheet; the choice of a tool gives that up. */
  pickPoint(picked: (point: Point2) => void): void {
    if (this.chosen.id !== 'pick') this.beforePick = this.chosen.id;
    this.choose('pick');
    this.picking.ask(picked);
  }

  /** Chooses another tool. While a recording is shown, or without rights, only those that change nothing can be chosen. */
  choose(id: ToolId): void {
    this.keyboardPointer.hide();
    const isChange = id !== 'view' && id !== 'measure' && id !== 'pick';
    if (isChange && this.replayBar.isOpen) {
      this.viewer.notices.notify('info', 'A recording cannot be changed: close it to return to the live sheet');
      return;
    }
    if (isChange && !this.rights.allows(Scope.CUT)) return;
    if (id === 'cut' || id === 'grab') this.events.onTried();
    if (this.chosen !== this.tools[id]) this.chosen.leave();
    this.chosen = this.tools[id];
    this.chosen.enter();
    this.buttons.show(id);
    this.updateCutPanel();
    this.measurePanel.setShown(id === 'measure');
    this.canvas.style.cursor = this.chosen.cursor;
    this.events.onChosen();
  }

  private updateCutPanel(): void {
    this.cutPanel.update(this.chosen === this.cut);
    this.drawingOptions.update();
  }
}
