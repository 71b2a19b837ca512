// Files of the workers, as the bundler finds them.
const kStart = {
  watch: () => new Worker(new URL('./watch_worker.ts', import.meta.url), { type: 'module' }),
  images: () => new Worker(new URL('./seldom_worker.ts', import.meta.url), { type: 'module', name: 'images' }),
  replay: () => new Worker(new URL('./seldom_worker.ts', import.meta.url), { type: 'module', name: 'replay' }),
};

/**
 * Starts one of the page's workers.
 * @param failed  called once if the worker cannot be loaded or fails; it is then ended and sends nothing more
 */
export function startWorker(name: keyof typeof kStart, failed: (why: string) => void): Worker {
  const worker = kStart[name]();
  const fail = (why: string) => {
    worker.onerror = worker.onmessageerror = null;
    worker.terminate();
    failed(why);
  };
  // The event has no message if the worker cannot be loaded.
  worker.onerror = ({ message }) => fail(message || 'its program cannot be loaded');
  worker.onmessageerror = () => fail('its messages cannot be read');
  return worker;
}
