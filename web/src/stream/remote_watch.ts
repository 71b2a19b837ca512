import type { Rejection } from '../gen/kerf/v1/stream_pb';
import type { ConnectionState } from './connection';
import { SheetCopy, copiedBuffers } from './sheet_copy';
import type { FrameCopy } from './sheet_copy';
import type { RecordingProgress } from './stream_recorder';
import type { AudienceNews, Pace, WatchRequestKind } from './watch';
import type { FromWorker, Port, StreamStart, ToWorker } from './watch_messages';

export interface RemoteWatchEvents {
  /** Called for a new state; `detail` is its reason, for people, and empty when all is well. */
  onState(state: ConnectionState, detail: string): void;
  /**
   * Called after each frame taken into `copy`. Each connection has a new copy, and another one begins when the sheet
   * goes back to a saved state.
   */
  onFrame(copy: SheetCopy, frame: FrameCopy): void;
  onRejection(rejection: Rejection): void;
  /** See WatchEvents.onNews(). */
  onNews(news: AudienceNews): void;
  /** @param parts  content of the file once the recording is finished, else undefined */
  onRecording(progress: RecordingProgress, parts: ArrayBuffer[] | undefined): void;
}

/** The page's side of a Watch that runs in a worker: the same calls, answered later. One at a time per port. */
export class RemoteWatch {
  /** Stays after a lost connection, so that the last frame remains visible. */
  copy: SheetCopy | undefined;
  state: ConnectionState = 'connecting';
  /** Reason of the state, for people; empty when all is well. */
  detail = '';

  private static lastId = 0;
  private readonly id = ++RemoteWatch.lastId;
  private isClosed = false;
  private hasNews = false;
  private spare: ArrayBuffer[] = [];
  private pace: Pace;

  /**
   * @param port  port of a worker that has a WatchService
   * @param url   address of the WebSocket, ws://HOST:PORT/watch
   * @param name  sheets/{sheet}
   */
  constructor(
    private readonly port: Port<ToWorker, FromWorker>,
    url: string,
    name: string,
    private readonly events: RemoteWatchEvents,
    options: StreamStart,
  ) {
    this.pace = options.pace;
    port.onmessage = ({ data }) => this.receive(data);
    port.postMessage({ kind: 'start', id: this.id, url, name, ...options });
  }

  /** Tells the server that all frames received so far have been used. Cheap if there is no new frame. */
  acknowledge(): void {
    if (!this.hasNews) return;
    this.hasNews = false;
    const { spare } = this;
    this.spare = [];
    this.port.postMessage({ kind: 'acknowledge', id: this.id, spare }, spare);
  }

  /** Sends a grab, drag, release or pointer; false if there is no connection, with which grabs and pointers end. */
  send(request: WatchRequestKind): boolean {
    if (this.state !== 'live') return false;
    this.port.postMessage({ kind: 'send', id: this.id, request });
    return true;
  }

  /** See Watch.setPace(). Cheap if the pace does not change. */
  setPace(pace: Pace): void {
    if (pace.isPaused === this.pace.isPaused && pace.maxRateHz === this.pace.maxRateHz) return;
    this.pace = pace;
    this.port.postMessage({ kind: 'pace', id: this.id, pace });
  }

  /** See Watch.retryNow(). */
  retryNow(): void {
    this.port.postMessage({ kind: 'retry', id: this.id });
  }

  /** Begins a recording with the next stream that starts on this port; see StreamRecorder. */
  record(header: Uint8Array<ArrayBuffer>, limitBytes: number): void {
    this.port.postMessage({ kind: 'record', header, limitBytes });
  }

  /** Ends a recording; onRecording() then gets the file. */
  stopRecording(): void {
    this.port.postMessage({ kind: 'stopRecording' });
  }

  /** Ends the stream. Frames and states still in transit are ignored; the file of a recording still arrives. */
  close(): void {
    this.isClosed = true;
    this.port.postMessage({ kind: 'close', id: this.id });
  }

  /** Call it when the worker has failed and will send nothing more. */
  fail(why: string): void {
    this.setState('ended', why);
  }

  private setState(state: ConnectionState, detail: string): void {
    this.state = state;
    this.detail = detail;
    this.events.onState(state, detail);
  }

  private receive(message: FromWorker): void {
    if ('id' in message && (this.isClosed || message.id !== this.id)) return;
    switch (message.kind) {
      case 'state':
        return this.setState(message.state, message.detail);
      case 'recording':
        return this.events.onRecording(message.progress, undefined);
      case 'recorded':
        return this.events.onRecording(message.progress, message.parts);
      case 'rejection':
        return this.events.onRejection(message.rejection);
      case 'news':
        return this.events.onNews(message.news);
      case 'frame':
        if (message.isFirst || !this.copy) this.copy = new SheetCopy();
        else if (this.copy.epoch !== message.frame.epoch) this.copy = SheetCopy.goneBack(this.copy);
        this.copy.take(message.frame, performance.now());
        this.hasNews = true;
        this.events.onFrame(this.copy, message.frame);
        this.spare.push(...copiedBuffers(message.frame));
        return;
    }
  }
}
