import { create } from '@bufbuild/protobuf';
import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import { ApiError } from '../src/api';
import type { call } from '../src/api';
import { AccessLinkSchema, AccessSchema, Scope } from '../src/gen/kerf/v1/access_service_pb';
import { AccessPanel } from '../src/ui/access/access_panel';
import { scopeText, untilText } from '../src/ui/access/access_text';
import { ShareForm } from '../src/ui/access/share_form';
import { FakeElement, fakePage } from './support/fake_page';

const kNotices: string[] = [];
const kReporter = {
  notify: (kind: string, text: string) => void kNotices.push(`${kind}: ${text}`),
  attempt: async <T>(run: () => Promise<T>, what = '') => {
    try {
      return await run();
    } catch (error) {
      kNotices.push(`error: ${what}${(error as Error).message}`);
      return undefined;
    }
  },
};
const settled = () => new Promise((resolve) => setTimeout(resolve));

beforeEach(() => void (kNotices.length = 0));
afterEach(() => vi.unstubAllGlobals());

describe('AccessPanel', () => {
  let at: (id: string) => FakeElement;
  let panel: AccessPanel;
  const button = new FakeElement();
  const toggle = vi.fn();
  const logOut = vi.fn();
  const open = vi.fn();
  const clear = vi.fn();

  beforeEach(() => {
    at = fakePage();
    Object.assign(document, { querySelector: () => button });
    logOut.mockReset();
    panel = new AccessPanel({ session: { logOut }, loginDialog: { open }, panels: { toggle }, share: { clear }, notices: kReporter });
  });

  it('is there only where the server asks for tokens', () => {
    panel.show(create(AccessSchema, { asksForTokens: false, scope: Scope.ADMIN }));
    expect(button.hidden).toBe(true);
    panel.show(create(AccessSchema, { asksForTokens: true, scope: Scope.VIEW }));
    expect(button.hidden).toBe(false);
    button.dispatchEvent(new Event('click'));
    expect(toggle).toHaveBeenCalledWith('access');
  });

  it('shows who is logged in, what that allows, and until when', () => {
    const access = { asksForTokens: true, tokenId: 'lab', scope: Scope.CUT, sheets: '*', expiresUnixS: 0n };
    panel.show(create(AccessSchema, access));
    const shown = () => ['token', 'scope', 'sheets', 'until'].map((name) => at(`access-${name}`).textContent);
    expect(shown()).toEqual(['lab', 'look and cut', 'all', 'it is withdrawn']);
    expect([at('access-in').hidden, at('access-out').hidden]).toEqual([false, true]);
    panel.show(create(AccessSchema, { ...access, sheets: 'demo-?', expiresUnixS: 1_800_000_000n }));
    expect(shown().slice(2)).toEqual(['demo-?', untilText(1_800_000_000n)]);
  });

  it('offers a login to a user who is logged out', () => {
    panel.show(undefined);
    expect([button.hidden, at('access-in').hidden, at('access-out').hidden]).toEqual([false, true, false]);
    at('log-in').dispatchEvent(new Event('click'));
    expect(open.mock.calls).toEqual([[undefined]]);
  });

  it('logs out, or says why not', async () => {
    at('log-out').dispatchEvent(new Event('click'));
    expect(logOut).toHaveBeenCalledOnce();
    logOut.mockRejectedValue(new ApiError('UNAVAILABLE', 'no connection'));
    at('log-out').dispatchEvent(new Event('click'));
    await settled();
    expect(kNotices).toEqual(['error: You are still logged in: no connection']);
  });

  it('forgets a link when it is closed', () => {
    panel.closed();
    expect(clear).toHaveBeenCalled();
  });
});

describe('ShareForm', () => {
  let at: (id: string) => FakeElement;
  let live: { sheetName: string };
  let form: ShareForm;
  let refusal: ApiError | undefined;
  const sent: [string, object][] = [];
  const writeText = vi.fn();
  const focused = vi.fn();
  const send = (async ({ name }: { name: string }, request: object) => {
    sent.push([name, request]);
    if (refusal) throw refusal;
    return create(AccessLinkSchema, { code: 'abc', path: '/?sheet=demo#code=abc', expiresUnixS: 1_800_000_000n });
  }) as unknown as typeof call;

  beforeEach(() => {
    at = fakePage();
    vi.stubGlobal('location', { origin: 'https://lab:8443' });
    vi.stubGlobal('navigator', { clipboard: { writeText } });
    writeText.mockReset();
    focused.mockReset();
    sent.length = 0;
    refusal = undefined;
    live = { sheetName: 'sheets/demo' };
    form = new ShareForm(live, kReporter, send);
    at('share-made').hidden = true;
    [at('share-scope').value, at('share-lifetime').value] = ['2', '86400'];
    Object.assign(at('share-copy'), { focus: focused });
  });

  it('makes a link to the open sheet, with the chosen rights for the chosen time', async () => {
    at('share-form').dispatchEvent(new Event('submit', { cancelable: true }));
    await settled();
    expect(sent).toEqual([['CreateLink', { scope: Scope.CUT, sheetId: 'demo', lifetimeS: 86400 }]]);
    expect(at('share-link').value).toBe('https://lab:8443/?sheet=demo#code=abc');
    expect(at('share-what').textContent).toBe(`Link to demo: look and cut, until ${untilText(1_800_000_000n)}`);
    expect(at('share-made').hidden).toBe(false);
    expect(focused).toHaveBeenCalledOnce();
    form.clear();
    expect([at('share-made').hidden, at('share-link').value]).toEqual([true, '']);
  });

  it('shows why there is no link, and no older one', async () => {
    await form.make();
    refusal = new ApiError('PERMISSION_DENIED', 'the link could do more than you');
    await form.make();
    expect([at('share-made').hidden, at('share-link').value]).toEqual([true, '']);
    expect([at('share-error').hidden, at('share-error').textContent]).toEqual([false, 'the link could do more than you']);
    live.sheetName = '';
    await form.make();
    expect(at('share-error').textContent).toBe('Open a sheet first');
    expect(sent).toHaveLength(2);
  });

  it('copies the link, or marks it where the browser has no clipboard for the page', async () => {
    await form.make();
    at('share-copy').dispatchEvent(new Event('click'));
    await settled();
    expect(writeText.mock.calls).toEqual([['https://lab:8443/?sheet=demo#code=abc']]);
    vi.stubGlobal('navigator', {});
    const marked = vi.fn();
    Object.assign(at('share-link'), { focus: marked, select: marked });
    at('share-copy').dispatchEvent(new Event('click'));
    await settled();
    await settled();
    expect(marked).toHaveBeenCalledTimes(2);
    expect(kNotices).toEqual([
      'success: The link is copied',
      'info: The browser does not let the page copy: copy the marked link by hand',
    ]);
  });
});

describe('texts about rights', () => {
  it('name scopes, also ones that this viewer does not know', () => {
    expect([Scope.VIEW, Scope.CUT, Scope.ADMIN, 7 as Scope].map(scopeText)).toEqual([
      'look only',
      'look and cut',
      'everything',
      'nothing',
    ]);
  });

  it('name times', () => {
    expect(untilText(1_800_000_000n)).toMatch(/^1[45] Jan 2027, \d\d:\d\d$/);
  });
});
