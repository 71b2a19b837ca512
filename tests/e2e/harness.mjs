// What viewer.test.mjs needs besides its steps: kerfd, Chromium, and a count of what passed.
import { spawn } from 'node:child_process';
import { createRequire } from 'node:module';
import { createInterface } from 'node:readline';
import { fileURLToPath } from 'node:url';

export const root = fileURLToPath(new URL('../..', import.meta.url));
const { chromium } = createRequire(`${root}/web/package.json`)('playwright-core');

// Rendering in software on a busy machine: no wait is about speed.
export const kPatienceMs = 90_000;

/** A kerfd with the demo scene; `http` may name an address to listen at again, `options` are others of its command line. */
export async function startKerfd(path, web, http = '127.0.0.1:0', options = []) {
  const scene = `${root}/deploy/scenes/demo.json`;
  const usual = ['--listen', '127.0.0.1:0', '--http', http, '--max-load', '0', '--web', web, '--scene', scene];
  const child = spawn(path, [...usual, ...options], { stdio: ['ignore', 'pipe', 'inherit'] });
  const exited = new Promise((resolve) => child.once('exit', (code, signal) => resolve(signal ?? code)));
  const line = await new Promise((resolve, reject) => {
    createInterface({ input: child.stdout }).once('line', resolve);
    exited.then((status) => reject(new Error(`kerfd ended with ${status} before it was ready`)));
    child.once('error', reject);
  });
  return {
    url: JSON.parse(line).http,
    /** Asks it to stop and gives its exit status. */
    stop: () => {
      child.kill('SIGTERM');
      return exited;
    },
  };
}

export function launchChromium(executablePath) {
  return chromium.launch({
    executablePath,
    args: [
      '--no-sandbox',
      '--disable-quic',
      '--no-first-run',
      '--disable-background-networking',
      '--disable-component-update',
      '--disable-sync',
      '--use-gl=angle',
      '--use-angle=gl-egl',
      '--ignore-gpu-blocklist',
    ],
  });
}

/** A unary call as any shell would make it. */
export async function post(url, method, request) {
  const response = await fetch(`${url}/kerf.v1.${method}`, {
    method: 'POST',
    body: JSON.stringify(request),
    headers: { 'content-type': 'application/json' },
  });
  const reply = await response.json();
  if (!response.ok) throw new Error(`${method}: ${response.status} ${JSON.stringify(reply)}`);
  return reply;
}

export function check(condition, message) {
  if (!condition) throw new Error(message);
}

/** Runs named steps in order; after a failure the rest, which builds on it, is not run and counts as failed. */
export class Steps {
  passed = 0;
  failed = 0;

  /**
   * @param onFailure  called with the name of the step that failed
   * @param afterEach  called after each step; what it throws fails the step
   */
  constructor(onFailure, afterEach) {
    this.onFailure = onFailure;
    this.afterEach = afterEach;
  }

  async step(name, run) {
    if (this.failed > 0) {
      this.failed += 1;
      console.log(`not run  ${name}`);
      return;
    }
    const started = performance.now();
    try {
      await run();
      await this.afterEach();
      this.passed += 1;
      console.log(`passed   ${name} (${((performance.now() - started) / 1000).toFixed(1)} s)`);
    } catch (error) {
      this.failed += 1;
      console.log(`FAILED   ${name}\n${error.stack}`);
      await this.onFailure(name);
    }
  }
}
