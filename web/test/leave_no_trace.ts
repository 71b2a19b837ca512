import { afterAll, vi } from 'vitest';

// Leaves timers, globals, mocks and modules as they were. Test files share a process, which takes a quarter of the time.
afterAll(() => {
  vi.useRealTimers();
  vi.unstubAllGlobals();
  vi.unstubAllEnvs();
  vi.restoreAllMocks();
  vi.resetModules();
});
