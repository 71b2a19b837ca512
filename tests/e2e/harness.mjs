// Starts kerfd and Chromium for the browser tests, and calls the server.
import { spawn } from 'node:child_process';
import { createRequire } from 'node:module';
import { createInterface } from 'node:readline';
import { fileURLToPath } from 'node:url';
import { within } from './steps.mjs';

export const root = fileURLToPath(new URL('../..', import.meta.url));
const { chromium } = createRequire(`${root}/web/package.json`)('playwright-core');

// Rendering in software on a busy machine: no wait is about speed.
export const kPatienceMs = 90_000;

async function launchKerfd(path, web, http, options) {
  const scene = `${root}/tests/e2e/demo.json`;
  const usual = ['--listen', '127.0.0.1:0', '--http', http, '--max-load', '0', '--data', 'none', '--web', web, '--scene', scene];
  const child = spawn(path, [...usual, ...options], { stdio: ['ignore', 'pipe', 'inherit'] });
  const exited = new Promise((resolve) => child.once('exit', (code, signal) => resolve(signal ?? code)));
  const line = await new Promise((resolve, reject) => {
    createInterface({ input: child.stdout }).once('line', resolve);
    exited.then((status) => reject(new Error(`kerfd ended with ${status} before it was ready`)));
    child.once('error', reject);
  });
  return { child, exited, url: JSON.parse(line).http };
}

/** A kerfd with the demo scene, which may be stopped and started at the same address. */
export class Server {
  constructor(path, web) {
    Object.assign(this, { path, web });
  }

  /** @param options  others of its command line */
  async start(options = []) {
    const http = this.url ? new URL(this.url).host : '127.0.0.1:0';
    this.process = await launchKerfd(this.path, this.web, http, options);
    this.url = this.process.url;
  }

  /** Asks it to stop, and checks its exit status. */
  async stop() {
    if (!this.process) return;
    const { child, exited } = this.process;
    this.process = undefined;
    child.kill('SIGTERM');
    const status = await within(kPatienceMs, exited, 'kerfd ends on SIGTERM').catch((error) => {
      child.kill('SIGKILL');
      throw error;
    });
    check(status === 0, `kerfd ended with ${status} on SIGTERM`);
  }

  /** The demo sheet from its beginning, and no other. */
  async startAgain() {
    await this.stop();
    await this.start();
  }
}

/** Starts a Chromium that draws WebGL by Mesa, without smooth edges, and pages without OpenGL. That takes a third less time. */
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
      '--webgl-msaa-sample-count=0',
      '--disable-gpu-rasterization',
      '--disable-gpu-compositing',
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
