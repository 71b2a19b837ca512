// Files of the workers, as the bundler finds them.
const kStart = {
  watch: () => new Worker(new URL('./watch_worker.ts', import.meta.url), { type: 'module' }),
  images: () => new Worker(new URL('./image_worker.ts', import.meta.url), { type: 'module' }),
  replay: () => new Worker(new URL('./replay_worker.ts', import.meta.url), { type: 'module' }),
};

/**
 * Starts one of the page's workers.
 * @param failed  called once if it cannot be loaded or fails: it is ended then, and answers nothing
 */
export function startWorker(name: keyof typeof kStart, failed: (why: string) => void): Worker {
  const worker = kStart[name]();
  const fail = (why: string) => {
    worker.onerror = worker.onmessageerror = null;
    worker.terminate();
    failed(why);
  };
  // A worker that cannot be loaded says no more than that.
  worker.onerror = ({ message }) => fail(message || 'its program cannot be loaded');
  worker.onmessageerror = () => fail('its messages cannot be read');
  return worker;
}
