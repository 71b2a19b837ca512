import { Scope } from './gen/kerf/v1/access_service_pb';
import type { Access } from './gen/kerf/v1/access_service_pb';
import { installHooks } from './hooks';
import { Stage } from './scene/stage';
import { LiveSheet } from './sheet/live_sheet';
import type { StreamWishes } from './sheet/live_sheet';
import { ShownSheet } from './sheet/shown_sheet';
import type { FrameCopy, SheetCopy } from './stream/sheet_copy';
import type { AudienceNews, Pace } from './stream/watch';
import type { Viewer } from './tools/tool';
import { AccessPanel } from './ui/access/access_panel';
import { takeCode } from './ui/access/link_code';
import { LoginDialog } from './ui/access/login_dialog';
import { Rights } from './ui/access/rights';
import { Session } from './ui/access/session';
import { ShareForm } from './ui/access/share_form';
import { AdaptiveDrawing } from './ui/adaptive_drawing';
import { AxisGizmo } from './ui/axis_gizmo';
import { ConnectionChip } from './ui/connection_chip';
import { CutList } from './ui/cuts/cut_list';
import { element } from './ui/dom';
import { DrawingLoop } from './ui/drawing_loop';
import { FileDrop } from './ui/file_drop';
import { FirstHint } from './ui/first_hint';
import { HistoryControls } from './ui/history_controls';
import { ImageMode } from './ui/image_mode';
import { bindKeys } from './ui/keys';
import { Notices } from './ui/notices';
import { PhysicsPanel } from './ui/physics/physics_panel';
import { People } from './ui/people/people';
import { PiecePanel } from './ui/piece_panel';
import { PlotPanel } from './ui/plots/plot_panel';
import { bindMoreControls } from './ui/more_controls';
import { RecordingControl } from './ui/recording_control';
import { ReplayBar } from './ui/replay_bar';
import { RoomForSheet } from './ui/room_for_sheet';
import { SaveMenu } from './ui/save_menu';
import { ServerRecordings } from './ui/server_recordings';
import { SheetLook } from './ui/sheet_look';
import { SheetNews } from './ui/sheet_news';
import { SheetOpener } from './ui/sheet_opener';
import { SheetChoice } from './ui/sheets/sheet_choice';
import { SidePanels } from './ui/side_panels';
import { SimulationControls } from './ui/simulation_controls';
import { SlowSheet } from './ui/slow_sheet';
import { StatePanel } from './ui/state_panel';
import { StatisticsPanel } from './ui/statistics_panel';
import { StatusLine } from './ui/status_line';
import { SvgFiles } from './ui/svg_files';
import { markTabbedFocus } from './ui/tabbed_focus';
import { Theme } from './ui/theme';
import { ToolChoice } from './ui/tool_choice';
import { Transfer } from './ui/transfer';
import { ViewLink } from './ui/view_link';

/** Makes the parts of the viewer and joins them. Each part sees the others only through interfaces that it declares. */
export class App {
  private readonly canvas = element<HTMLCanvasElement>('canvas');
  private readonly notices = new Notices(element('notices'));
  private readonly rights = new Rights(this.notices);
  private readonly session: Session = new Session({
    onNeeded: (why) => {
      this.loginDialog.open(why);
      this.connection.update();
    },
    onAccess: (access) => this.gotAccess(access),
    onLogin: () => this.loggedIn(),
    onLink: (follow) => this.offerLink(follow),
  });

  // The sheet: sources and receivers of its frames and settings.
  private readonly live: LiveSheet = new LiveSheet(
    () => this.wishes,
    {
      onState: (state) => {
        // The next connection begins with all who are there.
        if (state !== 'live') this.people.clear();
        this.connectionChanged();
      },
      onFrame: (copy, frame) => this.receiveLive(copy, frame),
      onNews: (news) => this.takeNews(news),
      onSettings: (sheet) => this.shown.set(sheet),
      onRejection: (rejection) => this.tools.grab.rejected(rejection),
      onRecording: (progress, parts) => this.recording.took(progress, parts),
      onFailed: (why) => {
        this.notices.notify('error', why);
        this.recording.lose();
      },
    },
    this.notices,
  );
  private readonly stage = new Stage(this.canvas);
  private readonly shown: ShownSheet = new ShownSheet(this.stage, {
    onSource: () => this.look.reset(),
    onSettings: (sheet, before) => {
      this.news.sawSettings(sheet, before);
      this.controls.show();
      this.physics.show(sheet);
    },
  });
  private readonly recording = new RecordingControl(this.live, this.shown, this.notices);
  private readonly replayBar: ReplayBar = new ReplayBar(
    {
      onOpened: (sheet) => this.opener.showReplay(sheet),
      onFrame: (copy, frame) => this.receive(copy, frame),
      onClosed: () => this.opener.leaveReplay(),
    },
    this.notices,
  );

  // The look of the sheet.
  private readonly theme = new Theme(element('theme'), (isDark) => this.stage.setDark(isDark));
  private readonly axes = new AxisGizmo(this.stage);
  private readonly look: SheetLook = new SheetLook({
    view: this.shown.view,
    shown: this.shown,
    live: this.live,
    stage: this.stage,
    notices: this.notices,
    isPictureShown: () => this.imageMode.isShown,
  });
  private readonly statistics = new StatisticsPanel();
  private readonly panels = new SidePanels(() => this.room.update());
  private readonly room = new RoomForSheet(this.stage, () => this.tools.cut.isStarted && !this.tools.cut.isOnSheet);
  private readonly imageMode: ImageMode = new ImageMode({
    live: this.live,
    stage: this.stage,
    look: this.look,
    theme: this.theme,
    statistics: this.statistics,
    notices: this.notices,
    isPicking: () => this.tools.tool.id !== 'view' || ['pieces', 'cuts'].includes(this.panels.open ?? '') || this.people.arePointersShown,
    showConnections: () => this.connectionChanged(),
    setMeshDrawn: (isDrawn) => this.shown.setDrawn(isDrawn),
  });
  private readonly connection = new ConnectionChip({
    live: this.live,
    imageMode: this.imageMode,
    replayBar: this.replayBar,
    session: this.session,
  });
  private readonly news = new SheetNews((kind, text) => this.notices.notify(kind, text));
  private readonly slowness = new SlowSheet(
    (kind, text) => this.notices.notify(kind, text),
    async () => ((await this.live.fetch()) && this.shown.sheet?.tickEstimate?.advice) || '',
  );

  // Controls of the sheet.
  private readonly firstHint = new FirstHint(element('first-hint'), element('first-hint-close'));
  private readonly viewer: Viewer = {
    stage: this.stage,
    overlay: element('overlay'),
    shown: this.shown,
    live: this.live,
    notices: this.notices,
  };
  private readonly tools: ToolChoice = new ToolChoice(
    this.viewer,
    this.replayBar,
    this.rights,
    {
      onChosen: () => this.room.update(),
      onTried: () => this.firstHint.close(),
      onCut: (name) => this.cuts.makers.made(name),
      onFileWanted: () => this.svgFiles.choose(),
    },
  );
  private readonly svgFiles = new SvgFiles(this.tools, this.notices, () => this.stage.focus());
  private readonly controls = new SimulationControls(this.live, this.shown, this.notices, () =>
    this.imageMode.isOn ? 2 : 1,
  );
  private readonly history = new HistoryControls(this.live, this.notices);
  private readonly physics = new PhysicsPanel(this.live, this.shown, this.notices);
  private readonly pieces = new PiecePanel(this.live, this.shown);
  private readonly cuts: CutList = new CutList(this.live, this.shown, this.history);
  private readonly plots: PlotPanel = new PlotPanel({
    live: this.live,
    shown: this.shown,
    notices: this.notices,
    pickPoint: (picked) => this.tools.pickPoint(picked),
  });
  private readonly states = new StatePanel(this.live, this.notices, () => (this.imageMode.isOn ? 2 : 1));

  private readonly people: People = new People({
    viewer: this.viewer,
    tools: this.tools,
    imageMode: this.imageMode,
    panels: this.panels,
  });
  private readonly opener = new SheetOpener({
    live: this.live,
    shown: this.shown,
    tools: this.tools,
    recording: this.recording,
    imageMode: this.imageMode,
    replayBar: this.replayBar,
    panels: this.panels,
    connection: this.connection,
    people: this.people,
  });
  private readonly sheets = new SheetChoice({
    live: this.live,
    opener: this.opener,
    replayBar: this.replayBar,
    connection: this.connection,
    panels: this.panels,
    notices: this.notices,
    rights: this.rights,
    focusStage: () => this.stage.focus(),
  });

  // Files.
  private readonly transfer = new Transfer(this.notices);
  private readonly saveMenu = new SaveMenu({
    stage: this.stage,
    shown: this.shown,
    live: this.live,
    look: this.look,
    imageMode: this.imageMode,
    recording: this.recording,
    replayBar: this.replayBar,
    transfer: this.transfer,
    notices: this.notices,
    rights: this.rights,
  });
  private readonly viewLink = new ViewLink({
    stage: this.stage,
    shown: this.shown,
    live: this.live,
    look: this.look,
    imageMode: this.imageMode,
    notices: this.notices,
  });
  private readonly serverRecordings = new ServerRecordings(
    { live: this.live, shown: this.shown, transfer: this.transfer, notices: this.notices },
    (name) => this.sheets.open(name),
  );

  // Rights and logins.
  private readonly loginDialog: LoginDialog = new LoginDialog(
    (token) => this.session.logIn({ token }),
    () => this.session.putOff(),
  );
  private readonly accessPanel = new AccessPanel({
    session: this.session,
    loginDialog: this.loginDialog,
    panels: this.panels,
    share: new ShareForm(this.live, this.notices),
    notices: this.notices,
  });

  private readonly loop = new DrawingLoop({
    stage: this.stage,
    shown: this.shown,
    live: this.live,
    replayBar: this.replayBar,
    look: this.look,
    imageMode: this.imageMode,
    tools: this.tools,
    pieces: this.pieces,
    cuts: this.cuts,
    plots: this.plots,
    axes: this.axes,
    people: this.people,
    quality: new AdaptiveDrawing({
      stage: this.stage,
      live: this.live,
      imageMode: this.imageMode,
      notices: this.notices,
    }),
    status: new StatusLine(),
    statistics: this.statistics,
  });

  constructor() {
    this.panels.add('pieces', this.pieces);
    this.panels.add('cuts', this.cuts);
    this.panels.add('plots', this.plots);
    this.panels.add('sheets', this.sheets);
    this.panels.add('states', this.states);
    this.panels.add('people', this.people.panel);
    this.panels.add('access', this.accessPanel);
    document.addEventListener('visibilitychange', () => {
      this.live.pageSeen();
      this.imageMode.pageSeen();
      this.people.pointing.update();
      if (!document.hidden) void this.session.look();
    });
    addEventListener('hashchange', () => {
      const code = takeCode();
      if (code !== '') this.session.follow(code);
    });
    new FileDrop({
      mesh: (file) => void (this.rights.allows(Scope.ADMIN) && this.sheets.dialog.open(file)),
      frames: (file) => void this.replayBar.open(file),
      run: (file) => void (this.rights.allows(Scope.ADMIN) && this.serverRecordings.play(file)),
      drawing: (file) => void this.svgFiles.take(file),
    });
    bindKeys({
      tools: this.tools,
      controls: this.controls,
      history: this.history,
      look: this.look,
      imageMode: this.imageMode,
      shown: this.shown,
      theme: this.theme,
      stage: this.stage,
      axes: this.axes,
      statistics: this.statistics,
      saveMenu: this.saveMenu,
      viewLink: this.viewLink,
      svgFiles: this.svgFiles,
      panels: this.panels,
      pointing: this.people.pointing,
      replayBar: this.replayBar,
      rights: this.rights,
    });
    bindMoreControls();
    markTabbedFocus(this.canvas);
    const { live, shown, stage, look, tools, replayBar, recording, imageMode, loop } = this;
    installHooks({ live, shown, stage, look, tools, replayBar, recording, imageMode, loop }, this.canvas);
  }

  /**
   * Begins to draw and opens the sheet named in the page's address, or else the first. Waits until the server can be
   * reached, and until the user is logged in if that is needed.
   * @param code  of the link that opened the page; else empty
   */
  async start(code: string): Promise<void> {
    this.viewLink.begin();
    this.loop.start();
    await Promise.all([this.session.start(code), this.sheets.start()]);
    await this.viewLink.follow();
  }

  private connectionChanged(): void {
    this.connection.update();
    if (this.live.watch?.state === 'lost') this.plots.lost(this.live.watch.detail);
    if (this.live.watch?.state === 'lost' || this.imageMode.state === 'lost') void this.session.check();
  }

  private takeNews(news: AudienceNews): void {
    this.people.take(news);
    if (news.case === 'activity') this.cuts.acted(news.value);
  }

  private gotAccess(access: Access | undefined): void {
    this.rights.set(access);
    this.accessPanel.show(access);
    this.people.panel.show(access);
    if (!this.rights.may(Scope.CUT) && !['measure', 'pick'].includes(this.tools.tool.id)) this.tools.choose('view');
  }

  private loggedIn(): void {
    this.loginDialog.close();
    this.connection.update();
    // Starts the streams again, because the old ones keep the rights that they began with.
    this.live.restart(true);
    this.imageMode.follow();
    this.sheets.refresh();
  }

  private offerLink(follow: () => Promise<void>): void {
    const text = 'You are logged in already. The link that you opened has rights of its own.';
    this.notices.offer(text, 'Use the link', () => void this.notices.attempt(follow, 'You stay logged in as before: '));
  }

  private get wishes(): StreamWishes {
    const probes = this.plots.probesFor(this.live.sheetName);
    return { strains: this.look.isByStrain, pace: this.pace, probes };
  }

  private get pace(): Pace {
    // A recording needs every tick, even while the page is hidden.
    if (this.recording.isOn) return { isPaused: false, maxRateHz: 0 };
    return { isPaused: document.hidden, maxRateHz: this.imageMode.isShown && !this.plots.isOn ? this.imageMode.meshRateHz : 0 };
  }

  private receiveLive(copy: SheetCopy, frame: FrameCopy): void {
    this.receive(copy, frame);
    this.plots.take(copy);
    const { stats, arrivedMs } = frame;
    if (!stats || !this.live.isWatched) return;
    const { sheetName } = this.live;
    this.news.saw(sheetName, copy, stats);
    void this.slowness.saw(sheetName, stats, arrivedMs);
  }

  private receive(copy: SheetCopy, { delivery, stats }: FrameCopy): void {
    this.shown.receive(copy);
    if (!this.imageMode.isOn) this.statistics.arrived(delivery, stats);
  }
}
