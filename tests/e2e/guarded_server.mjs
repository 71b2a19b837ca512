import { createHash, randomBytes } from 'node:crypto';
import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { check, Server } from './harness.mjs';

/** A kerfd that asks for tokens. */
export class GuardedServer {
  #folder = mkdtempSync(join(tmpdir(), 'kerf-e2e-'));
  #lines = [];
  #tokens = {};

  /** @param like  a Server with the programs */
  constructor({ path, web }) {
    this.server = new Server(path, web);
  }

  /** Makes a token; before start(). */
  add(id, scope) {
    const token = `kerf_${id}_${randomBytes(33).toString('base64url').slice(0, 43)}`;
    this.#tokens[id] = token;
    this.#lines.push(`${id} ${createHash('sha256').update(token).digest('hex')} scope=${scope}`);
    return token;
  }

  async start() {
    this.#write(this.#lines);
    await this.server.start(['--tokens', this.#file]);
    this.url = this.server.url;
  }

  async stop() {
    await this.server.stop();
    rmSync(this.#folder, { recursive: true });
  }

  /** Calls a method with a token. */
  post(id, method, request) {
    return fetch(`${this.url}/kerf.v1.${method}`, {
      method: 'POST',
      body: JSON.stringify(request),
      headers: { 'content-type': 'application/json', authorization: `Bearer ${this.#tokens[id]}` },
    });
  }

  /** Withdraws all tokens, and with them all logins; then the server knows the tokens once more. */
  async withdraw(id) {
    await this.#read(id, [], 401);
    await this.#read(id, this.#lines, 200);
  }

  /** Makes all tokens end, and with them all logins. */
  async expire(id) {
    await this.#read(id, this.#lines.map((line) => `${line} until=2020-01-01`), 401);
  }

  /** Makes all tokens good again after expire(). */
  async renew(id) {
    await this.#read(id, this.#lines, 200);
  }

  async #read(id, lines, status) {
    this.#write(lines);
    this.server.process.child.kill('SIGHUP');
    const asks = () => this.post(id, 'AccessService/GetAccess', {});
    const end = Date.now() + 20_000;
    let answer = await asks();
    while (answer.status !== status && Date.now() < end) answer = await asks();
    check(answer.status === status, `the token file was not read again: ${answer.status}`);
  }

  get #file() {
    return join(this.#folder, 'tokens');
  }

  #write(lines) {
    writeFileSync(this.#file, lines.map((line) => `${line}\n`).join(''));
  }
}
