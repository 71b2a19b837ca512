import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import { call } from '../src/api';
import { Scope } from '../src/gen/kerf/v1/access_service_pb';
import { SheetService } from '../src/gen/kerf/v1/sheets_pb';
import { Session } from '../src/ui/access/session';
import { TokenServer, kOpenToAll, kViewer, settled } from './support/token_server';

const kCutter = { ...kViewer, scope: 'SCOPE_CUT' };
const kGetAccess = '/kerf.v1.AccessService/GetAccess';
const kPause = '/kerf.v1.SheetService/PauseSheet';

describe('Session', () => {
  let server: TokenServer;
  let session: Session;
  let events: string[];
  let followLink: (() => Promise<void>) | undefined;
  const pause = () => call(SheetService.method.pauseSheet, { name: 'sheets/a' });

  beforeEach(() => {
    server = new TokenServer();
    server.tokens.set('kerf_lab_secret', kViewer);
    server.codes.set('abc', kCutter);
    events = [];
    followLink = undefined;
    session = new Session({
      onNeeded: (why) => events.push(`needed ${why?.reason ?? ''}`.trim()),
      onAccess: (access) => events.push(`access ${access ? Scope[access.scope] : 'none'}`),
      onLogin: () => events.push('login'),
      onLink: (follow) => {
        events.push('link');
        followLink = follow;
      },
    });
  });

  afterEach(() => {
    vi.useRealTimers();
    vi.unstubAllGlobals();
  });

  it('asks for nothing where the server asks for no tokens', async () => {
    server.login = kOpenToAll;
    await session.start('');
    expect([events, session.isOut]).toEqual([['access ADMIN'], false]);
    expect(server.requests).toEqual([kGetAccess]);
  });

  it('ignores the code of a link where the server asks for no tokens', async () => {
    server.login = kOpenToAll;
    await session.start('abc');
    session.follow('abc');
    expect(events).toEqual(['access ADMIN']);
    expect(server.requests).toEqual([kGetAccess]);
  });

  it('asks a new user for a token, without a reproach, and waits for it', async () => {
    const started = session.start('');
    await settled();
    expect([events.splice(0), session.isOut]).toEqual([['needed'], true]);
    await session.logIn({ token: 'kerf_lab_secret' });
    await started;
    expect(server.requests[1]).toBe('/login {"token":"kerf_lab_secret"}');
    expect(session.isOut).toBe(false);
    expect(events).toEqual(['access VIEW', 'login', 'access VIEW']);
  });

  it('keeps asking while the token is wrong, with the server’s words', async () => {
    void session.start('');
    await settled();
    const error = await session.logIn({ token: 'kerf_lab_typo' }).catch((refused: unknown) => refused);
    expect(error).toMatchObject({ code: 'UNAUTHENTICATED', reason: 'TOKEN_UNKNOWN', message: 'refused: TOKEN_UNKNOWN' });
    expect([events, session.isOut]).toEqual([['needed'], true]);
  });

  it('says so where the browser keeps no cookies', async () => {
    server.keepsCookies = false;
    void session.start('');
    await settled();
    await expect(session.logIn({ token: 'kerf_lab_secret' })).rejects.toThrow(/does not keep the login: allow cookies/);
    expect([events, session.isOut]).toEqual([['needed'], true]);
  });

  it('logs in by the code of a link, without asking', async () => {
    await session.start('abc');
    expect(server.requests.slice(0, 2)).toEqual([kGetAccess, '/login {"code":"abc"}']);
    expect(events).toEqual(['access CUT', 'login', 'access CUT']);
  });

  it('asks for a token where the code was used before, and uses the code once', async () => {
    server.codes.clear();
    const started = session.start('abc');
    await settled();
    expect(events.splice(0)).toEqual(['needed CODE_UNKNOWN']);
    await session.logIn({ token: 'kerf_lab_secret' });
    await started;
    expect(server.requests.filter((path) => path.includes('abc'))).toHaveLength(1);
    expect(events).not.toContain('link');
  });

  it('leaves a user who is logged in the choice whether to follow a link', async () => {
    server.login = kViewer;
    await session.start('abc');
    expect(events.splice(0)).toEqual(['access VIEW', 'link']);
    expect(server.requests).toEqual([kGetAccess]);
    await followLink!();
    expect(events).toEqual(['access CUT', 'login']);
  });

  it('follows a link that is opened in the page while it asks', async () => {
    void session.start('');
    await settled();
    session.follow('wrong');
    await settled();
    expect(events.splice(0)).toEqual(['needed', 'needed CODE_UNKNOWN']);
    session.follow('abc');
    await settled();
    expect(events.slice(0, 2)).toEqual(['access CUT', 'login']);
  });

  it('asks once when a login ends in the middle, and then repeats all that was refused', async () => {
    server.login = kViewer;
    await session.start('');
    events.length = 0;
    server.login = undefined;
    server.reason = 'TOKEN_EXPIRED';
    const calls = Promise.all([pause(), pause(), session.check()]);
    await settled();
    expect(events.splice(0)).toEqual(['needed TOKEN_EXPIRED']);
    server.requests.length = 0;
    await session.logIn({ token: 'kerf_lab_secret' });
    await calls;
    expect(server.requests.filter((path) => path === kPause)).toHaveLength(2);
    expect(events.slice(0, 2)).toEqual(['access VIEW', 'login']);
    expect(events).not.toContain('needed TOKEN_EXPIRED');
  });

  it('says that the login has ended where another tab has logged out', async () => {
    server.login = kViewer;
    await session.start('');
    server.login = undefined;
    void pause();
    await settled();
    expect(events.at(-1)).toBe('needed TOKEN_MISSING');
  });

  it('does not ask again for a call that was refused before a login', async () => {
    server.login = kViewer;
    await session.start('');
    server.login = undefined;
    const answered = vi.mocked(fetch);
    let release!: () => void;
    vi.stubGlobal('fetch', async (path: string, init: RequestInit) => {
      const response = await answered(path, init);
      if (path === kPause) await new Promise<void>((resolve) => (release = resolve));
      return response;
    });
    const late = pause();
    void session.check();
    await settled();
    await session.logIn({ token: 'kerf_lab_secret' });
    events.length = 0;
    vi.stubGlobal('fetch', answered);
    release();
    await late;
    expect(events.filter((event) => event.startsWith('needed'))).toEqual([]);
  });

  it('lets the user put the login off, and does not ask again by itself', async () => {
    void session.start('');
    await settled();
    session.putOff();
    void pause();
    await settled();
    expect([events, session.isOut]).toEqual([['needed', 'access none'], true]);
    await session.logIn({ token: 'kerf_lab_secret' });
    // The dialog that a login closes puts nothing off.
    session.putOff();
    await settled();
    expect(events.slice(2).filter((event) => !event.startsWith('access VIEW'))).toEqual(['login']);
  });

  it('continues where another tab has logged in', async () => {
    const started = session.start('');
    await settled();
    await session.look();
    expect(session.isOut).toBe(true);
    server.login = kCutter;
    await session.look();
    await started;
    expect([session.isOut, events.slice(0, 3)]).toEqual([false, ['needed', 'access CUT', 'login']]);
    const { length } = server.requests;
    await session.look();
    expect(server.requests).toHaveLength(length);
  });

  it('gives up a call whose transfer is cancelled while it waits', async () => {
    const cancelling = new AbortController();
    const waiting = call(SheetService.method.pauseSheet, { name: 'sheets/a' }, { signal: cancelling.signal });
    await settled();
    cancelling.abort();
    await expect(waiting).rejects.toThrow('cancelled');
  });

  it('asks again until the server can be reached, and once at a time', async () => {
    vi.useFakeTimers();
    server.login = kViewer;
    server.isReachable = false;
    const started = session.start('');
    await vi.advanceTimersByTimeAsync(1500);
    expect([events, server.requests.length]).toEqual([[], 2]);
    server.isReachable = true;
    await vi.advanceTimersByTimeAsync(1000);
    await started;
    expect(events).toEqual(['access VIEW']);
    await Promise.all([session.check(), session.check()]);
    expect(server.requests).toHaveLength(4);
  });

  it('logs out and begins again; without a login, too', async () => {
    const reload = vi.fn();
    vi.stubGlobal('location', { reload });
    server.login = kViewer;
    await session.logOut();
    expect([server.login, reload.mock.calls.length]).toEqual([undefined, 1]);
    server.isReachable = false;
    await expect(session.logOut()).rejects.toThrow('cannot be reached');
    expect(reload).toHaveBeenCalledOnce();
  });
});
