import { randomBytes } from 'node:crypto';
import { createServer, request } from 'node:http';
import { connect } from 'node:net';

const kOpenPaths = /^\/($|\?|assets\/|index\.html|docs)/;
const kGetAccess = '/kerf.v1.AccessService/GetAccess';
const kCreateLink = '/kerf.v1.AccessService/CreateLink';

function answer(response, status, body, headers = {}) {
  response.writeHead(status, { 'content-type': 'application/json', ...headers });
  response.end(JSON.stringify(body));
}

function refuse(response, status, code, reason, message) {
  const info = { '@type': 'type.googleapis.com/google.rpc.ErrorInfo', reason, domain: 'kerf' };
  answer(response, status, { code, message, details: [info] });
}

async function json(incoming) {
  return JSON.parse(Buffer.concat(await incoming.toArray()).toString() || '{}');
}

/**
 * Stands before a kerfd without tokens and asks browsers for a login, as `kerfd --tokens` does: cookies, refusals of
 * calls and of WebSockets, links. Rights themselves are not enforced.
 */
export class TokenGate {
  /** Rights by token, as the JSON of kerf.v1.Access. */
  tokens = new Map();
  codes = new Map();
  /** Bodies of CreateLink. */
  links = [];
  /** Reason of the next refusals. */
  reason = 'TOKEN_MISSING';
  #logins = new Map();
  #sockets = new Set();

  static async start(url) {
    const gate = new TokenGate();
    gate.to = new URL(url);
    gate.server = createServer((incoming, response) => void gate.#take(incoming, response));
    gate.server.on('upgrade', (incoming, socket, head) => gate.#upgrade(incoming, socket, head));
    await new Promise((resolve) => gate.server.listen(0, '127.0.0.1', resolve));
    gate.url = `http://127.0.0.1:${gate.server.address().port}`;
    return gate;
  }

  /** Ends all logins and their streams. */
  withdraw(reason) {
    this.reason = reason;
    this.#logins.clear();
    for (const socket of this.#sockets) socket.destroy();
  }

  async stop() {
    this.withdraw('TOKEN_MISSING');
    this.server.closeAllConnections();
    await new Promise((resolve) => this.server.close(resolve));
  }

  #access({ headers }) {
    return this.#logins.get(/kerf=(\w+)/.exec(headers.cookie ?? '')?.[1]);
  }

  async #take(incoming, response) {
    const { url, method } = incoming;
    const access = this.#access(incoming);
    if (url === '/login') return this.#logIn(await json(incoming), response);
    if (kOpenPaths.test(url)) return this.#pass(incoming, response);
    if (!access) return refuse(response, 401, 16, this.reason, this.reason === 'TOKEN_EXPIRED' ? 'the token has expired' : 'give a token');
    if (method === 'POST' && !incoming.headers['x-kerf-csrf']) return refuse(response, 403, 7, 'CSRF_HEADER_MISSING', 'no x-kerf-csrf');
    if (url === '/logout') {
      this.withdraw('TOKEN_MISSING');
      return answer(response, 200, {});
    }
    if (url === kGetAccess) return answer(response, 200, access);
    if (url === kCreateLink) return this.#makeLink(await json(incoming), access, response);
    return this.#pass(incoming, response);
  }

  #logIn({ token, code }, response) {
    const access = this.tokens.get(token) ?? this.codes.get(code);
    this.codes.delete(code);
    if (!access && code) return refuse(response, 401, 16, 'CODE_UNKNOWN', 'the link was used before, or has ended');
    if (!access) return refuse(response, 401, 16, 'TOKEN_UNKNOWN', 'there is no such token');
    const id = randomBytes(12).toString('hex');
    this.#logins.set(id, access);
    return answer(response, 200, access, { 'set-cookie': `kerf=${id}; HttpOnly; SameSite=Strict; Path=/` });
  }

  #makeLink(wanted, access, response) {
    this.links.push(wanted);
    const code = randomBytes(12).toString('hex');
    const expires_unix_s = String(Math.round(Date.now() / 1000) + wanted.lifetimeS);
    this.codes.set(code, { ...access, scope: wanted.scope, sheets: wanted.sheetId, expires_unix_s });
    answer(response, 200, { code, path: `/?sheet=${wanted.sheetId}#code=${code}`, expires_unix_s });
  }

  #pass(incoming, response) {
    const { hostname, port } = this.to;
    const { url: path, method, headers } = incoming;
    const upstream = request({ hostname, port, path, method, headers }, (answered) => {
      response.writeHead(answered.statusCode, answered.headers);
      answered.pipe(response);
    });
    upstream.on('error', () => response.destroy());
    incoming.pipe(upstream);
  }

  #upgrade(incoming, socket, head) {
    socket.on('error', () => socket.destroy());
    if (!this.#access(incoming)) return socket.end('HTTP/1.1 401 Unauthorized\r\nContent-Length: 0\r\nConnection: close\r\n\r\n');
    const upstream = connect(Number(this.to.port), this.to.hostname);
    const lines = incoming.rawHeaders.flatMap((name, i, all) => (i % 2 === 0 ? [`${name}: ${all[i + 1]}`] : []));
    upstream.write([`GET ${incoming.url} HTTP/1.1`, ...lines, '', ''].join('\r\n'));
    upstream.write(head);
    socket.pipe(upstream).pipe(socket);
    this.#sockets.add(socket);
    upstream.on('error', () => upstream.destroy());
    upstream.on('close', () => socket.destroy());
    socket.on('close', () => {
      this.#sockets.delete(socket);
      upstream.destroy();
    });
  }
}
