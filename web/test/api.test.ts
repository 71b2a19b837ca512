// Every request of the viewer: POSTs have the header without which the server takes no cookie, and there are no others.

import { readFileSync, readdirSync } from 'node:fs';
import ts from 'typescript';
import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import * as api from '../src/api';
import { SheetSchema, SheetService } from '../src/gen/kerf/v1/sheets_pb';

const kSource = new URL('../src/', import.meta.url);

/** A request that the browser was asked to make. */
interface Sent {
  path: string;
  method: string;
  headers: Record<string, string>;
}

class FakeRequest {
  static readonly sent: Sent[] = [];
  readonly upload = {};
  readonly status = 200;
  readonly responseText = '{}';
  onload: () => void = () => {};
  private readonly headers: Record<string, string> = {};
  private target = { method: '', path: '' };

  open(method: string, path: string): void {
    this.target = { method, path };
  }
  setRequestHeader(name: string, value: string): void {
    this.headers[name] = value;
  }
  send(): void {
    FakeRequest.sent.push({ ...this.target, headers: this.headers });
    this.onload();
  }
}

describe('requests', () => {
  const { sent } = FakeRequest;
  const transfer = { signal: new AbortController().signal, onProgress: () => {} };

  beforeEach(() => {
    sent.length = 0;
    vi.stubGlobal('XMLHttpRequest', FakeRequest);
    vi.stubGlobal('fetch', async (path: string, { method = 'GET', headers = {} }: Partial<Sent> = {}) => {
      sent.push({ path, method, headers });
      return Response.json({});
    });
  });
  afterEach(() => vi.unstubAllGlobals());

  // Each function of api.ts that sends something; a new one has to be added here.
  const kSenders: Partial<Record<keyof typeof api, () => Promise<unknown>>> = {
    call: () => api.call(SheetService.method.pauseSheet, { name: 'sheets/a' }),
    sendFile: () => api.sendFile(SheetSchema, '/recordings?sheet=a', new Blob(['a']), transfer),
    fetchFile: () => api.fetchFile('/sheets/a.rec', transfer),
    logIn: () => api.logIn({ token: 'kerf_lab_secret' }),
    logOut: () => api.logOut(),
    presentAccess: () => api.presentAccess(),
  };
  const kOthers = ['ApiError', 'guardCalls', 'requestBody'];

  it('are made by known functions', () => {
    expect(Object.keys(api).sort()).toEqual([...Object.keys(kSenders), ...kOthers].sort());
  });

  it.each(Object.entries(kSenders))('of %s have the header of a POST', async (name, send) => {
    await send();
    expect(sent.length).toBeGreaterThan(0);
    for (const { path, method, headers } of sent) {
      if (name === 'fetchFile') expect([path, method]).toEqual(['/sheets/a.rec', 'GET']);
      else expect([path, method, headers['x-kerf-csrf']]).toEqual([path, 'POST', '1']);
    }
  });

  it('of a call that tells its progress have the header, too', async () => {
    await api.call(SheetService.method.createSheet, {}, transfer);
    expect(sent.map(({ method, headers }) => [method, headers])).toEqual([
      ['POST', { 'x-kerf-csrf': '1', 'content-type': 'application/json' }],
    ]);
  });

  it('never have a token or a code in their path', async () => {
    await api.logIn({ token: 'kerf_lab_secret' });
    await api.logIn({ code: 'abc' });
    expect(sent.map(({ path }) => path).filter((path) => /secret|abc/.test(path))).toEqual([]);
  });
});

/** Uses of a browser's ways to send requests, as "file: name". */
function senders(file: string, source: string): string[] {
  const found: string[] = [];
  const visit = (node: ts.Node): void => {
    const called = ts.isCallExpression(node) || ts.isNewExpression(node) ? node.expression : undefined;
    const isMember = called && ts.isPropertyAccessExpression(called);
    const name = isMember ? called.name.text : called && ts.isIdentifier(called) ? called.text : '';
    const isGlobal = !isMember || /^(globalThis|window|self)$/.test(called.expression.getText());
    const isSender = /^(XMLHttpRequest|EventSource|sendBeacon)$/.test(name) || (name === 'fetch' && isGlobal);
    if (isSender) found.push(`${file}: ${name}`);
    ts.forEachChild(node, visit);
  };
  visit(ts.createSourceFile(file, source, ts.ScriptTarget.ES2022, true));
  return found;
}

describe('the sources', () => {
  it('send requests in api.ts alone, by POST in one place', () => {
    const files = readdirSync(kSource, { recursive: true, encoding: 'utf8' }).filter((file) => file.endsWith('.ts'));
    const found = files.flatMap((file) => senders(file, readFileSync(new URL(file, kSource), 'utf8')));
    expect(found.sort()).toEqual(['api.ts: XMLHttpRequest', 'api.ts: fetch', 'api.ts: fetch']);
  });

  it('keep nothing of a login', () => {
    const texts = ['api.ts', ...readdirSync(new URL('ui/access/', kSource)).map((file) => `ui/access/${file}`)];
    expect(texts.length).toBeGreaterThan(5);
    for (const file of texts) {
      expect(readFileSync(new URL(file, kSource), 'utf8'), file).not.toMatch(/localStorage|sessionStorage|indexedDB|document\.cookie|caches\b/);
    }
  });

  it('have no form that would send its fields by itself', () => {
    const page = readFileSync(new URL('../index.html', kSource), 'utf8');
    expect(page).not.toMatch(/<form[^>]*\b(action|method="(?!dialog))/);
    expect(page.match(/<input type="password"[^>]*>/)![0]).not.toMatch(/\bname=/);
  });

  it.each([
    ["fetch('/a')", true],
    ["window.fetch('/a')", true],
    ["await globalThis.fetch('/a')", true],
    ['new XMLHttpRequest()', true],
    ["navigator.sendBeacon('/a')", true],
    ["new EventSource('/a')", true],
    ['this.answers.fetch()', false],
    ['class A { fetch() {} }', false],
  ])('are searched for requests: %s', (source, isFound) => {
    expect(senders('a.ts', source).length > 0).toBe(isFound);
  });
});
