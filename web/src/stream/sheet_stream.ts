import { RemoteWatch } from './remote_watch';
import type { RemoteWatchEvents } from './remote_watch';
import { streamUrl } from './stream_url';
import type { StreamStart } from './watch_messages';
import { startWorker } from './workers';

export interface SheetStreamEvents extends RemoteWatchEvents {
  /** Called when the worker has failed and its recording is lost. `why` is a sentence for people. */
  onFailed(why: string): void;
}

/** The stream of one sheet at a time, in a worker. After a failure the next stream starts a new worker. */
export class SheetStream {
  private current: RemoteWatch | undefined;
  private worker: Worker | undefined;

  constructor(private readonly events: SheetStreamEvents) {
    // Starts early, so that the worker loads while the page finds out which sheet to open.
    this.worker = this.startWorker();
  }

  /** The present stream; undefined if no sheet is watched. */
  get watch(): RemoteWatch | undefined {
    return this.current;
  }

  /**
   * Watches a sheet in place of the last one.
   * @param name  sheets/{sheet}
   */
  start(name: string, options: StreamStart): void {
    this.close();
    this.worker ??= this.startWorker();
    this.current = new RemoteWatch(this.worker, streamUrl('watch'), name, this.events, options);
  }

  close(): void {
    this.current?.close();
    this.current = undefined;
  }

  private startWorker(): Worker {
    return startWorker('watch', (why) => {
      const failure = `The viewer can no longer receive the sheet: ${why}. Open the sheet again, or reload the page`;
      this.worker = undefined;
      this.current?.fail(failure);
      this.events.onFailed(failure);
    });
  }
}
