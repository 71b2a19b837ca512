import { call, guardCalls, logIn, logOut, presentAccess } from '../../api';
import type { ApiError } from '../../api';
import { AccessService } from '../../gen/kerf/v1/access_service_pb';
import type { Access } from '../../gen/kerf/v1/access_service_pb';

const kRetryMs = 1000;

export interface SessionEvents {
  /**
   * Called when the user must log in, once until a login.
   * @param why  the refusal; undefined if the user has just come
   */
  onNeeded(why: ApiError | undefined): void;
  /** Called when the user's rights have arrived; undefined: the user does not log in now. */
  onAccess(access: Access | undefined): void;
  /** Called after a login: streams that began before it have the rights of then. */
  onLogin(): void;
  /** Called for a link that was opened by a user who is logged in already; `follow` logs in by the link. */
  onLink(follow: () => Promise<void>): void;
}

/**
 * The login of this browser. Calls that the server refuses because it does not know the user wait for a login: by the
 * code of a link, or by a token. Only the browser keeps the login, as a cookie; tokens and used codes are forgotten.
 */
export class Session {
  private access: Access | undefined;
  private code = '';
  private waiting: { login: Promise<void>; end: () => void } | undefined;
  private checking: Promise<boolean> | undefined;

  constructor(private readonly events: SessionEvents) {
    guardCalls((refusal) => this.loggedIn(refusal));
  }

  /** True from a refusal until a login. */
  get isOut(): boolean {
    return this.waiting !== undefined;
  }

  /**
   * Finds out what the user may do. Waits until the server can be reached, and for a login if one is needed.
   * @param code  of the link that opened the page; else empty
   */
  async start(code: string): Promise<void> {
    this.code = code;
    while (!(await this.check())) await new Promise((resolve) => setTimeout(resolve, kRetryMs));
    const unused = this.takeCode();
    if (unused !== '') this.follow(unused);
  }

  /**
   * Asks the server what the user may do; a user whom it does not know has to log in. False if it cannot be reached.
   * Call it when a stream fails, because a browser does not say that a handshake was refused, or why.
   */
  check(): Promise<boolean> {
    this.checking ??= call(AccessService.method.getAccess, {})
      .then(
        (access) => this.take(access),
        (error: ApiError) => error.code !== 'UNAVAILABLE',
      )
      .finally(() => (this.checking = undefined));
    return this.checking;
  }

  /** Takes the code of a link that was opened in this page. */
  follow(code: string): void {
    if (this.waiting) void this.tryCode(code);
    else if (!this.access) this.code = code;
    else if (this.access.asksForTokens) this.events.onLink(() => this.logIn({ code }));
  }

  /** @throws ApiError */
  async logIn(credentials: { token: string } | { code: string }): Promise<void> {
    this.enter(await logIn(credentials));
  }

  /** Does without a login for now; calls keep waiting for one. */
  putOff(): void {
    if (this.waiting) this.events.onAccess(undefined);
  }

  /** Continues if another tab has logged in. Call it when the page is shown. */
  async look(): Promise<void> {
    if (!this.waiting) return;
    const access = await presentAccess().catch(() => undefined);
    if (access && this.waiting) this.enter(access);
  }

  /**
   * Logs out, in all tabs.
   * @throws ApiError
   */
  async logOut(): Promise<void> {
    await logOut();
    // Begins again, so that nothing of the last user stays in the page.
    location.reload();
  }

  private loggedIn(refusal: ApiError): Promise<void> {
    if (!this.waiting) {
      let end!: () => void;
      this.waiting = { login: new Promise((resolve) => (end = resolve)), end };
      const code = this.takeCode();
      const isNew = !this.access && refusal.reason === 'TOKEN_MISSING';
      if (code !== '') void this.tryCode(code);
      else this.events.onNeeded(isNew ? undefined : refusal);
    }
    return this.waiting.login;
  }

  private async tryCode(code: string): Promise<void> {
    await this.logIn({ code }).catch((error: ApiError) => this.events.onNeeded(error));
  }

  private enter(access: Access): void {
    this.take(access);
    this.waiting?.end();
    this.waiting = undefined;
    this.events.onLogin();
  }

  private take(access: Access): boolean {
    this.access = access;
    this.events.onAccess(access);
    return true;
  }

  // A code is used once.
  private takeCode(): string {
    const { code } = this;
    this.code = '';
    return code;
  }
}
