import { vi } from 'vitest';

interface Refusal {
  status: number;
  code: number;
  reason: string;
}

/** Rights as the JSON of kerf.v1.Access. */
export interface AccessJson {
  asks_for_tokens: boolean;
  token_id?: string;
  scope: string;
  sheets?: string;
  expires_unix_s?: string;
}

export const kViewer: AccessJson = { asks_for_tokens: true, token_id: 'lab', scope: 'SCOPE_VIEW', sheets: '*' };
export const kOpenToAll: AccessJson = { asks_for_tokens: false, scope: 'SCOPE_ADMIN' };

/** A server that asks for tokens, behind fetch(). It knows one browser, whose cookie is `login`. */
export class TokenServer {
  /** Path of each request, in their order; with the body for /login. */
  readonly requests: string[] = [];
  readonly tokens = new Map<string, AccessJson>();
  readonly codes = new Map<string, AccessJson>();
  /** False for a browser that refuses cookies. */
  keepsCookies = true;
  login: AccessJson | undefined;
  /** The reason for which a request without a login is refused. */
  reason = 'TOKEN_MISSING';
  isReachable = true;

  constructor() {
    vi.stubGlobal('fetch', async (path: string, { body }: { body?: string } = {}) => {
      this.requests.push(path === '/login' ? `${path} ${body}` : path);
      if (!this.isReachable) throw new TypeError('Failed to fetch');
      return this.answer(path, body ?? '');
    });
  }

  private answer(path: string, body: string): Response {
    if (path === '/login') return this.logIn(JSON.parse(body) as { token?: string; code?: string });
    if (path === '/logout') {
      this.login = undefined;
      return Response.json({});
    }
    if (!this.login) return this.refuse({ status: 401, code: 16, reason: this.reason });
    return Response.json(path.endsWith('/GetAccess') ? this.login : {});
  }

  private logIn({ token = '', code = '' }: { token?: string; code?: string }): Response {
    const access = this.tokens.get(token) ?? this.codes.get(code);
    this.codes.delete(code);
    if (!access) return this.refuse({ status: 401, code: 16, reason: token === '' ? 'CODE_UNKNOWN' : 'TOKEN_UNKNOWN' });
    if (this.keepsCookies) this.login = access;
    return Response.json(access);
  }

  private refuse({ status, code, reason }: Refusal): Response {
    const info = { '@type': 'type.googleapis.com/google.rpc.ErrorInfo', reason, domain: 'kerf' };
    return Response.json({ code, message: `refused: ${reason}`, details: [info] }, { status });
  }
}

/** Waits until all that can be answered is answered. */
export function settled(): Promise<void> {
  return new Promise((resolve) => setTimeout(resolve));
}
