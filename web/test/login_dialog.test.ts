import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import { ApiError } from '../src/api';
import { LoginDialog } from '../src/ui/access/login_dialog';

// The parts of an element that the dialog uses.
class FakeElement extends EventTarget {
  hidden = true;
  open = false;
  disabled = false;
  value = '';
  textContent = '';
  isFocused = false;
  readonly attributes = new Map<string, string>();
  readonly parts: Record<string, FakeElement> = {};

  querySelector(selector: string): FakeElement {
    return (this.parts[selector] ??= new FakeElement());
  }
  setAttribute(name: string, value: string): void {
    this.attributes.set(name, value);
  }
  removeAttribute(name: string): void {
    this.attributes.delete(name);
  }
  showModal(): void {
    if (this.open) throw new Error('it is open already');
    this.open = true;
  }
  close(): void {
    if (this.open) this.dispatchEvent(new Event('close'));
    this.open = false;
  }
  focus(): void {
    this.isFocused = true;
  }
  select(): void {}
}

describe('LoginDialog', () => {
  let page: Record<string, FakeElement>;
  let dialog: LoginDialog;
  const given: string[] = [];
  const closed = vi.fn();
  let refusal: ApiError | undefined;
  const at = (id: string) => (page[id] ??= new FakeElement());
  const submit = async () => {
    at('login').querySelector('form').dispatchEvent(new Event('submit', { cancelable: true }));
    await new Promise((resolve) => setTimeout(resolve));
  };

  beforeEach(() => {
    page = {};
    given.length = 0;
    closed.mockClear();
    refusal = undefined;
    vi.stubGlobal('document', { getElementById: at });
    dialog = new LoginDialog(async (token) => {
      given.push(token);
      if (refusal) throw refusal;
      dialog.close();
    }, closed);
  });
  afterEach(() => vi.unstubAllGlobals());

  it('has no reproach for a user who has just come, and the reason for others', () => {
    dialog.open(undefined);
    expect([at('login').open, at('login-error').hidden]).toEqual([true, true]);
    dialog.open(new ApiError('UNAUTHENTICATED', 'the token has expired', '', 'TOKEN_EXPIRED'));
    expect([at('login-error').hidden, at('login-error').textContent]).toEqual([false, 'the token has expired']);
    for (const reason of ['TOKEN_MISSING', 'LOGIN_UNKNOWN']) {
      dialog.open(new ApiError('UNAUTHENTICATED', 'give a token', '', reason));
      expect(at('login-error').textContent).toMatch(/^You are logged out/);
    }
  });

  it('gives the token without what a paste brings along, and forgets it', async () => {
    dialog.open(undefined);
    at('login-token').value = ' kerf_lab_secret\n';
    await submit();
    expect([given, at('login-token').value, at('login').open]).toEqual([['kerf_lab_secret'], '', false]);
    expect(closed).toHaveBeenCalledOnce();
  });

  it('shows the server’s refusal at the field, until the user types', async () => {
    dialog.open(undefined);
    refusal = new ApiError('UNAUTHENTICATED', 'no such token', '', 'TOKEN_UNKNOWN');
    at('login-token').value = 'kerf_lab_typo';
    await submit();
    expect([at('login').open, at('login-error').hidden, at('login-error').textContent]).toEqual([true, false, 'no such token']);
    expect([at('login-token').attributes.get('aria-invalid'), at('login-token').isFocused]).toEqual(['true', true]);
    expect(at('login-enter').disabled).toBe(false);
    at('login-token').dispatchEvent(new Event('input'));
    expect([at('login-error').hidden, at('login-token').attributes.has('aria-invalid')]).toEqual([true, false]);
  });

  it('asks the server nothing without a token', async () => {
    dialog.open(undefined);
    at('login-token').value = '  ';
    await submit();
    expect([given, at('login-error').textContent]).toEqual([[], 'Give a token']);
  });

  it('can be closed without a token', () => {
    dialog.open(undefined);
    at('login-token').value = 'kerf_half';
    at('login').querySelector('[data-close]').dispatchEvent(new Event('click'));
    expect([at('login').open, at('login-token').value, closed.mock.calls.length]).toEqual([false, '', 1]);
  });
});
