import { call } from '../api';
import { SheetService } from '../gen/kerf/v1/sheets_pb';
import type { Sheet } from '../gen/kerf/v1/sheets_pb';
import type { Rejection } from '../gen/kerf/v1/stream_pb';
import { NewestAnswer } from '../newest_answer';
import type { Reporter } from '../notifier';
import type { ConnectionState } from '../stream/connection';
import { FrameClock, unixTimeMs } from '../stream/frame_clock';
import type { RemoteWatch } from '../stream/remote_watch';
import { SettingsFollower } from '../stream/settings_follower';
import type { FrameCopy, SheetCopy } from '../stream/sheet_copy';
import { SheetStream } from '../stream/sheet_stream';
import type { RecordingProgress } from '../stream/stream_recorder';
import type { AudienceNews, Pace, ProbeRequest } from '../stream/watch';
import type { OpenSheet } from './open_sheet';

/** The stream that the viewer wants now. */
export interface StreamWishes {
  strains: boolean;
  /** Quantities that the server measures for each frame, see SheetCopy.probeValues. */
  probes?: ProbeRequest[];
  pace: Pace;
}

export interface LiveSheetEvents {
  /** Called when the state of the connection has changed. */
  onState(state: ConnectionState): void;
  onFrame(copy: SheetCopy, frame: FrameCopy): void;
  onSettings(sheet: Sheet): void;
  onRejection(rejection: Rejection): void;
  onNews(news: AudienceNews): void;
  /** @param parts  content of the file once the recording is finished, else undefined */
  onRecording(progress: RecordingProgress, parts: ArrayBuffer[] | undefined): void;
  /** Called when the stream has failed and its recording is lost. `why` is a sentence for people. */
  onFailed(why: string): void;
}

/** The live sheet that is open: its stream, and its settings as the server has them. */
export class LiveSheet implements OpenSheet {
  sheetName = '';

  private readonly stream: SheetStream;
  // Failures are ignored, because the stream reports a lost connection or a deleted sheet.
  private readonly answers = new NewestAnswer<Sheet>(
    () => call(SheetService.method.getSheet, { name: this.sheetName }),
    (sheet) => this.answered(sheet),
  );
  private readonly settings = new SettingsFollower(() => this.answers.fetch());
  private clock = new FrameClock();
  // Each connection has a new copy, and so has a sheet that goes back to a saved state.
  private copy: SheetCopy | undefined;

  /** @param wishes  called whenever a stream starts or its pace may change */
  constructor(
    private readonly wishes: () => StreamWishes,
    private readonly events: LiveSheetEvents,
    private readonly reporter: Reporter,
  ) {
    this.stream = new SheetStream({
      onState: (state) => {
        // The first frame of the next connection then fetches the settings again.
        if (state !== 'live') this.settings.reset();
        events.onState(state);
      },
      onFrame: (copy, frame) => this.received(copy, frame),
      onRejection: (rejection) => events.onRejection(rejection),
      onNews: (news) => events.onNews(news),
      onRecording: (progress, parts) => {
        events.onRecording(progress, parts);
        // Sets the pace here, because a recording may also end in a hidden page, where no drawing does so.
        this.followPace();
      },
      onFailed: (why) => events.onFailed(why),
    });
  }

  /** The stream; undefined without a live sheet, and while a recording is shown. */
  get watch(): RemoteWatch | undefined {
    return this.stream.watch;
  }

  get isWatched(): boolean {
    return this.watch !== undefined;
  }

  /** Age of the newest frame, milliseconds; undefined before the first. */
  get ageMs(): number | undefined {
    return this.clock.ageMs(unixTimeMs());
  }

  /** @param name  sheets/{sheet} */
  open(name: string): void {
    this.sheetName = name;
    this.startStream(false);
  }

  /** Stops watching; sheetName stays. */
  close(): void {
    this.stream.close();
    this.settings.reset();
  }

  /** Starts another stream of the same sheet. `goesOn`: it continues from the present copy's triangles. */
  restart(goesOn: boolean): void {
    if (this.isWatched) this.startStream(goesOn);
  }

  /** Call it when the page was shown or hidden. */
  pageSeen(): void {
    this.followPace();
    if (!document.hidden) this.watch?.retryNow();
  }

  /** Requests the frame rate that is wanted now. Cheap if nothing has changed. */
  followPace(): void {
    this.watch?.setPace(this.wishes().pace);
  }

  /** Moves the vertices to their positions at `nowMs`; true if any has moved. */
  advance(nowMs: number): boolean {
    return this.watch?.copy?.advance(nowMs) ?? false;
  }

  /** Tells the server that the newest frame has been used. */
  acknowledge(): void {
    this.watch?.acknowledge();
  }

  /** Fetches the settings; false if that failed. */
  fetch(): Promise<boolean> {
    return this.answers.fetch();
  }

  async refresh(): Promise<void> {
    await this.answers.refresh();
  }

  /** Runs a call that changes the sheet and whose answer has the new settings. */
  command(run: () => Promise<Sheet>): Promise<void> {
    return this.answers.command(() => this.reporter.attempt(run));
  }

  private startStream(goesOn: boolean): void {
    this.stream.start(this.sheetName, { ...this.wishes(), goesOn });
  }

  // Ignores the answer for a sheet that is no longer shown.
  private answered(sheet: Sheet): void {
    if (this.isWatched && sheet.name === this.sheetName) this.events.onSettings(sheet);
  }

  private received(copy: SheetCopy, frame: FrameCopy): void {
    if (copy !== this.copy) {
      // The settings may be others, and the clock that of a restarted server.
      this.copy = copy;
      this.clock = new FrameClock();
      this.settings.reset();
    }
    const { stats, arrivedMs } = frame;
    if (stats) {
      this.clock.arrived(stats.publishedUnixUs, arrivedMs);
      if (this.isWatched) this.settings.saw(stats.settingsVersion);
    }
    this.events.onFrame(copy, frame);
    // A hidden page gets frames while it records, but draws nothing that would acknowledge them.
    if (document.hidden) this.acknowledge();
  }
}
