import { FrameCopier } from './frame_copier';
import type { SheetMirror } from './mirror';
import type { Delivery } from './stream_meter';
import { StreamRecorder } from './stream_recorder';
import { Watch } from './watch';
import type { WatchEvents } from './watch';
import type { FromWorker, Port, ToWorker } from './watch_messages';

// Interval of progress messages of a recording, which the page shows as text.
const kTellEveryMs = 200;

/**
 * The worker's side of a stream: holds the connection, decodes frames and sends copies to the page, which draws at the
 * same time. The server sends no more than the page acknowledges, so no frames queue up between worker and page.
 */
export class WatchService {
  private watch: Watch | undefined;
  private id = 0;
  private name = '';
  private shown: SheetMirror | undefined;
  private readonly copier = new FrameCopier();
  private recorder: StreamRecorder | undefined;
  private toldMs = 0;

  constructor(private readonly page: Port<FromWorker, ToWorker>) {
    page.onmessage = ({ data }) => this.receive(data);
  }

  private receive(message: ToWorker): void {
    switch (message.kind) {
      case 'start':
        return this.start(message);
      case 'record':
        this.recorder = new StreamRecorder(message.header, message.limitBytes);
        return;
      case 'stopRecording':
        return this.stopRecording();
    }
    if (message.id !== this.id) return;
    switch (message.kind) {
      case 'acknowledge':
        this.copier.spare.put(message.spare);
        return this.watch?.acknowledge();
      case 'send':
        this.watch?.send(message.request);
        return;
      case 'pace':
        return this.watch?.setPace(message.pace);
      case 'retry':
        return this.watch?.retryNow();
      case 'close':
        return this.watch?.close();
    }
  }

  private start({ id, url, name, strains, probes, goesOn, pace }: ToWorker & { kind: 'start' }): void {
    const from = goesOn && name === this.name ? this.watch?.mirror : undefined;
    this.watch?.close();
    this.id = id;
    this.name = name;
    this.shown = undefined;
    const events: WatchEvents = {
      onState: (state, detail) => this.post({ kind: 'state', id, state, detail }),
      onFrame: (mirror, delivery, bytes) => {
        this.record(mirror, bytes);
        this.handOn(id, mirror, delivery);
      },
      onRejection: (rejection) => this.post({ kind: 'rejection', id, rejection }),
      onNews: (news) => this.post({ kind: 'news', id, news }),
    };
    const startsWhole = () => this.recorder !== undefined;
    this.watch = new Watch(url, name, events, { strains, probes, from, startsWhole });
    this.watch.setPace(pace);
  }

  private record(mirror: SheetMirror, bytes: Uint8Array): void {
    const { recorder } = this;
    if (!recorder || recorder.progress.isFull) return;
    const nowMs = performance.now();
    recorder.add(bytes, mirror.sequence === 1, nowMs);
    const { progress } = recorder;
    if (!progress.isFull && nowMs - this.toldMs < kTellEveryMs) return;
    this.toldMs = nowMs;
    this.post({ kind: 'recording', progress });
  }

  private stopRecording(): void {
    const { recorder } = this;
    this.recorder = undefined;
    if (!recorder) return;
    const parts = recorder.finish();
    this.post({ kind: 'recorded', progress: recorder.progress, parts }, parts);
  }

  private handOn(id: number, mirror: SheetMirror, delivery: Delivery): void {
    const isFirst = mirror !== this.shown;
    this.shown = mirror;
    const { frame, buffers } = this.copier.copy(mirror, delivery, isFirst);
    this.post({ kind: 'frame', id, frame, isFirst }, buffers);
  }

  private post(message: FromWorker, transfer: Transferable[] = []): void {
    this.page.postMessage(message, transfer);
  }
}
