import { call } from './api';
import { SheetService, Sheet_RunState } from './gen/kerf/v1/sheets_pb';
import type { Sheet } from './gen/kerf/v1/sheets_pb';
import { Surface } from './geometry/surface';
import { NewestAnswer } from './newest_answer';
import { pieceCentre } from './scene/piece_highlight';
import { SheetScene } from './scene/sheet_scene';
import { Stage } from './scene/stage';
import { FrameClock, unixTimeMs } from './stream/frame_clock';
import type { Rejection } from './gen/kerf/v1/stream_pb';
import { SettingsFollower } from './stream/settings_follower';
import { RemoteWatch } from './stream/remote_watch';
import type { FrameCopy, SheetCopy } from './stream/sheet_copy';
import type { ConnectionState } from './stream/connection';
import type { RecordingProgress } from './stream/stream_recorder';
import type { Pace } from './stream/watch';
import { startWorker } from './stream/workers';
import { CutTool } from './tools/cut_tool';
import { GrabTool } from './tools/grab_tool';
import { KeyboardPointer } from './tools/keyboard_pointer';
import { PinTool } from './tools/pin_tool';
import { PointerRouter } from './tools/pointer_router';
import type { NoticeKind, Tool, ToolId, Viewer } from './tools/tool';
import { ViewTool } from './tools/view_tool';
import { AdaptiveDrawing } from './ui/adaptive_drawing';
import { showState } from './ui/connection_chip';
import type { ShownState } from './ui/connection_chip';
import { CutPanel } from './ui/cut_panel';
import { errorText } from './ui/error_text';
import { FirstHint } from './ui/first_hint';
import { HistoryControls } from './ui/history_controls';
import { ImageMode } from './ui/image_mode';
import { Notices } from './ui/notices';
import { PhysicsPanel } from './ui/physics/physics_panel';
import { PiecePanel } from './ui/piece_panel';
import { SidePanels } from './ui/side_panels';
import { Choice, element, setLiveControls } from './ui/dom';
import { RecordingControl } from './ui/recording_control';
import { ReplayBar } from './ui/replay_bar';
import { isStill } from './ui/run_text';
import { SaveMenu } from './ui/save_menu';
import { SheetLook } from './ui/sheet_look';
import { SheetNews } from './ui/sheet_news';
import { SlowSheet } from './ui/slow_sheet';
import { SimulationControls } from './ui/simulation_controls';
import { StatisticsPanel } from './ui/statistics_panel';
import { StatusLine } from './ui/status_line';
import { SvgFiles } from './ui/svg_files';
import { Theme } from './ui/theme';
import { Transfer } from './ui/transfer';

/** The viewer of one sheet: what the server sends goes in, pictures and the tools' calls come out. */
export class App implements Viewer {
  readonly overlay = element('overlay');
  readonly stage: Stage;
  readonly controls: SimulationControls;
  readonly history = new HistoryControls(this);
  readonly cutTool: CutTool;
  readonly grabTool: GrabTool;
  readonly theme: Theme;
  readonly svgFiles = new SvgFiles(this);
  readonly panels = new SidePanels();
  readonly pieces = new PiecePanel(this);
  readonly keyboardPointer: KeyboardPointer;
  sheetName = '';
  surface: Surface | undefined;
  watch: RemoteWatch | undefined;
  sheet: Sheet | undefined;
  tool: Tool;
  framesDrawn = 0;

  // Holds the connection and decodes frames.
  private worker: Worker | undefined = this.startWorker();
  private readonly canvas = element<HTMLCanvasElement>('canvas');
  private readonly sheetScene: SheetScene;
  readonly look: SheetLook;
  readonly notices = new Notices(element('notices'));
  private readonly news = new SheetNews((kind, text) => this.notify(kind, text));
  private readonly slowness = new SlowSheet(
    (kind, text) => this.notify(kind, text),
    async () => ((await this.answers.fetch()) && this.sheet?.tickEstimate?.advice) || '',
  );
  private readonly firstHint = new FirstHint(element('first-hint'), element('first-hint-close'));
  private readonly status = new StatusLine();
  private readonly physics = new PhysicsPanel(this);
  readonly statistics = new StatisticsPanel();
  readonly imageMode = new ImageMode(this);
  private readonly drawing = new AdaptiveDrawing(this);
  readonly recording = new RecordingControl(this);
  readonly replayBar = new ReplayBar(this);
  readonly transfer = new Transfer(this);
  readonly saveMenu = new SaveMenu(this);
  private readonly tools: Record<ToolId, Tool>;
  readonly cutPanel: CutPanel;
  private readonly toolChoice: Choice<ToolId>;
  private clock = new FrameClock();
  private hasNewFrame = false;
  // What is drawn next came since the last drawing.
  private hasArrived = false;
  private isFitted = false;
  // Ignores failures: the stream tells about a lost connection or a sheet that is gone.
  private readonly answers = new NewestAnswer<Sheet>(
    () => call(SheetService.method.getSheet, { name: this.sheetName }),
    (sheet) => this.told(sheet),
  );
  private readonly settings = new SettingsFollower(() => this.answers.fetch());

  constructor() {
    this.stage = new Stage(this.canvas);
    this.theme = new Theme(element('theme'), (isDark) => this.stage.setDark(isDark));
    this.sheetScene = new SheetScene(this.stage);
    this.look = new SheetLook(this, this.sheetScene.view);
    this.cutTool = new CutTool(this, () => this.cutPanel?.update(this.tool === this.cutTool));
    this.grabTool = new GrabTool(this);
    this.tools = { view: new ViewTool(), cut: this.cutTool, grab: this.grabTool, pin: new PinTool(this) };
    this.tool = this.tools.view;
    this.cutPanel = new CutPanel(
      this.cutTool,
      () => this.focusStage(),
      () => this.svgFiles.choose(),
    );
    this.toolChoice = new Choice<ToolId>(element('tools'), 'tool', (id) => this.choose(id));
    this.controls = new SimulationControls(this);
    this.keyboardPointer = new KeyboardPointer(this, () => this.tool);
    this.panels.add('pieces', this.pieces);
    new PointerRouter(
      element('stage'),
      this.canvas,
      this.stage,
      () => this.tool,
      () => this.keyboardPointer.hide(),
    );
    document.addEventListener('visibilitychange', () => {
      this.watch?.setPace(this.pace);
      if (!document.hidden) this.watch?.retryNow();
      this.imageMode.seen();
    });
    this.choose('view');
    requestAnimationFrame((nowMs) => this.draw(nowMs));
  }

  private get pace(): Pace {
    // A recording is of every tick, whatever is seen meanwhile.
    if (this.recording.isOn) return { isPaused: false, maxRateHz: 0 };
    return { isPaused: document.hidden, maxRateHz: this.imageMode.isShown ? this.imageMode.meshRateHz : 0 };
  }

  /** Another stream of the same sheet. `goesOn`: from the triangles that are here. */
  restartWatch(goesOn: boolean): void {
    if (!this.watch) return;
    this.watch.close();
    this.watch = this.startWatch(this.sheetName, goesOn);
  }

  choose(id: ToolId): void {
    this.keyboardPointer.hide();
    if (this.replayBar.isOpen && id !== 'view') {
      this.notify('info', 'A recording cannot be changed: close it to return to the live sheet');
      return;
    }
    if (id === 'cut' || id === 'grab') this.firstHint.close();
    if (this.tool !== this.tools[id]) this.tool.leave();
    this.tool = this.tools[id];
    this.tool.enter();
    this.toolChoice.show(id);
    this.cutPanel.update(this.tool === this.cutTool);
    this.canvas.style.cursor = this.tool.cursor;
  }

  /** Gives the keyboard to the tool. */
  focusStage(): void {
    this.canvas.focus({ preventScroll: true });
  }

  /** Watches no sheet; nothing of the last one stays. A recording that is shown, or read, goes on. */
  close(): void {
    if (this.replayBar.hasFile) {
      this.sheetName = '';
      return;
    }
    this.letGo();
    this.imageMode.clear();
    this.sheetScene.object.visible = false;
    this.stage.invalidate();
  }

  // The last sheet stays in the picture until the next one comes.
  private letGo(): void {
    this.tool.leave();
    this.recording.stop();
    this.watch?.close();
    this.watch = undefined;
    this.imageMode.close();
    this.settings.reset();
    this.sheetName = '';
    this.surface = undefined;
    this.hasNewFrame = false;
    this.sheet = undefined;
    this.isFitted = false;
  }

  /** @param name  sheets/{sheet} */
  open(name: string): void {
    this.letGo();
    this.replayBar.leave();
    this.sheetName = name;
    this.watch = this.startWatch(name, false);
    this.imageMode.follow();
    void this.refreshSheet();
  }

  /** Opens it unless a recording is shown, or read; what comes after that. */
  offer(name: string): void {
    if (this.replayBar.hasFile) this.sheetName = name;
    else this.open(name);
  }

  /** Shows the frames of a recording in place of the live sheet. */
  showReplay(sheet: Sheet): void {
    // Where closing it leads back to.
    const { sheetName } = this;
    this.letGo();
    this.imageMode.leave();
    this.sheetName = sheetName;
    this.choose('view');
    // The other panels are the live sheet's.
    if (this.panels.open !== 'sheets') this.panels.close();
    setLiveControls(false);
    this.setSheet(sheet);
    this.showConnection('replay', '');
  }

  /** Of a WebSocket of the server that this page is from. */
  streamUrl(path: 'watch' | 'images'): string {
    const { protocol, host } = location;
    return `${protocol === 'https:' ? 'wss' : 'ws'}://${host}/${path}`;
  }

  private startWorker(): Worker {
    return startWorker('watch', (why) => {
      const told = `The viewer can no longer receive the sheet: ${why}. Open the sheet again, or reload the page`;
      this.worker = undefined;
      this.watch?.fail(told);
      this.notify('error', told);
      this.recording.lose();
    });
  }

  private startWatch(name: string, goesOn: boolean): RemoteWatch {
    this.worker ??= this.startWorker();
    const events = {
      onState: (state: ConnectionState) => {
        // The first frame of the next connection asks again.
        if (state !== 'live') this.settings.reset();
        this.tellConnection();
      },
      onFrame: (copy: SheetCopy, frame: FrameCopy) => this.receive(copy, frame),
      onRejection: (rejection: Rejection) => this.grabTool.rejected(rejection),
      onRecording: (progress: RecordingProgress, parts: ArrayBuffer[] | undefined) => {
        this.recording.took(progress, parts);
        // One that is full may end while nobody looks.
        this.watch?.setPace(this.pace);
      },
    };
    const options = { strains: this.look.isByStrain, goesOn, pace: this.pace };
    return new RemoteWatch(this.worker, this.streamUrl('watch'), name, events, options);
  }

  fit(): void {
    if (this.surface) this.sheetScene.fit(this.surface, this.sheet?.scene?.colliders ?? []);
  }

  /** Streams of the sheet to this page: the mesh, and pictures where they are shown. */
  get numStreams(): number {
    return this.imageMode.isOn ? 2 : 1;
  }

  get topologyVersion(): number | undefined {
    return this.surface?.mirror.topologyVersion;
  }

  highlight(label: number | undefined): void {
    this.sheetScene.view.highlight(label);
    this.showAgain();
  }

  centre(label: number): void {
    const { surface } = this;
    if (surface) this.stage.lookAt(pieceCentre(surface.mirror, label));
  }

  notify(kind: NoticeKind, text: string, details?: readonly string[]): void {
    this.notices.add(kind, text, details);
  }

  async attempt<T>(run: () => Promise<T>, what = ''): Promise<T | undefined> {
    try {
      return await run();
    } catch (error) {
      this.notify('error', `${what}${errorText(error as Error)}`);
      return undefined;
    }
  }

  async refreshSheet(): Promise<void> {
    await this.answers.refresh();
  }

  /** Runs a call that changes the sheet and is answered by it. */
  command(run: () => Promise<Sheet>): Promise<void> {
    return this.answers.command(() => this.attempt(run));
  }

  // Ignores an answer of a sheet that is no longer shown.
  private told(sheet: Sheet): void {
    if (this.watch && sheet.name === this.sheetName) this.setSheet(sheet);
  }

  private setSheet(sheet: Sheet): void {
    if (sheet.runState === Sheet_RunState.FAILED && this.sheet?.runState !== Sheet_RunState.FAILED) {
      this.notify('error', 'The sheet is frozen at its last good tick. Reset it to go on.');
    }
    this.sheet = sheet;
    this.controls.show();
    this.physics.show(sheet);
    this.sheetScene.set(sheet);
    this.showAgain();
  }

  /** Says how the connections of the live sheet are: the mesh's, or the pictures' where that is well. */
  tellConnection(): void {
    if (!this.watch) return;
    const { state, detail } = (this.watch.state === 'live' && this.imageMode.trouble) || this.watch;
    this.showConnection(state, detail);
  }

  showConnection(state: ShownState, detail: string): void {
    // Whether there is a server does not matter to a recording.
    if (!this.replayBar.isOpen || state === 'replay') showState(state, detail);
  }

  /** Sheet and colliders are drawn here, or are in the picture that the server draws. */
  setMeshDrawn(isDrawn: boolean): void {
    this.sheetScene.setDrawn(isDrawn);
    this.showAgain();
  }

  /** Draws what is here once more, in a look that may have changed. */
  showAgain(): void {
    this.hasNewFrame = this.surface !== undefined;
    this.stage.invalidate();
  }

  /** A frame of the live stream, or of a recording. */
  receive(copy: SheetCopy, { stats, arrivedMs, delivery }: FrameCopy): void {
    if (this.surface?.mirror !== copy) {
      // A new connection, perhaps to another server: neither its clock nor its settings need be the old ones.
      this.surface = new Surface(copy);
      this.clock = new FrameClock();
      this.settings.reset();
      this.look.reset();
    }
    if (stats) {
      this.clock.arrived(stats.publishedUnixUs, arrivedMs);
      if (this.watch) {
        this.settings.saw(stats.settingsVersion);
        this.news.saw(this.sheetName, copy.epoch, stats);
        void this.slowness.saw(this.sheetName, stats, arrivedMs);
      }
    }
    if (!this.imageMode.isOn) this.statistics.arrived(delivery, stats);
    this.sheetScene.object.visible = true;
    this.hasNewFrame = true;
    this.hasArrived = true;
    this.stage.invalidate();
    // Frames of a recording come to a hidden page, too, where no drawing acknowledges them.
    if (document.hidden) this.watch?.acknowledge();
  }

  private draw(nowMs: number): void {
    requestAnimationFrame((nextMs) => this.draw(nextMs));
    this.watch?.setPace(this.pace);
    if (this.watch?.copy?.advance(nowMs) || this.replayBar.advance(nowMs)) this.showAgain();
    const { imageMode } = this;
    // A drawing on the sheet is faint where a fold hides it, in pictures of the server as well.
    if (this.sheetScene.setHiding(imageMode.isShown && this.cutTool.isOnSheet)) this.showAgain();
    const isStale = this.drawing.begin(nowMs, this.stage.advance());
    if (isStale) {
      if (this.surface && this.hasNewFrame) this.takeFrame(this.surface);
      this.tool.update();
      this.stage.draw();
      imageMode.look();
    }
    // Under a picture of the server what is drawn here is not the sheet.
    const isDrawn = imageMode.draw() || (isStale && !imageMode.isShown);
    if (isDrawn) this.drawn(nowMs);
    const mesh = this.surface?.mirror;
    const figures = mesh && imageMode.isShown ? imageMode.figures(mesh) : mesh;
    this.status.update(figures, this.ageMs, nowMs);
    this.statistics.update(figures, imageMode.isShown ? imageMode.format : 'mesh', nowMs);
  }

  private drawn(nowMs: number): void {
    this.framesDrawn += 1;
    this.status.drawn(nowMs);
    this.statistics.drawn(nowMs, this.hasArrived || this.imageMode.isShown ? this.ageMs : undefined);
    this.hasArrived = false;
  }

  /** The sheet that is shown moves by itself. */
  get isMoving(): boolean {
    if (!this.watch) return this.replayBar.playing?.isPlaying ?? false;
    return this.watch.state === 'live' && !isStill(this.surface?.mirror.stats);
  }

  // A sheet that does not move sends nothing: its last frame is not old, it is the present.
  private get ageMs(): number | undefined {
    if (this.imageMode.isShown) return this.imageMode.ageMs;
    if (!this.watch || !this.isMoving) return undefined;
    return this.clock.ageMs(unixTimeMs());
  }

  private takeFrame(surface: Surface): void {
    this.hasNewFrame = false;
    if (!this.isFitted) {
      this.fit();
      // Once more when the colliders are known.
      this.isFitted = this.sheet !== undefined;
    }
    this.sheetScene.update(surface);
    this.look.color();
    this.watch?.acknowledge();
    this.pieces.update();
  }
}
