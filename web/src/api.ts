import { create, fromJson, toJson } from '@bufbuild/protobuf';
import type { DescMessage, DescMethodUnary, JsonValue, MessageInitShape, MessageShape } from '@bufbuild/protobuf';
import { AccessService } from './gen/kerf/v1/access_service_pb';
import type { Access } from './gen/kerf/v1/access_service_pb';

/** A call that the server refused. The code is UNAVAILABLE if the server could not be reached. */
export class ApiError extends Error {
  override readonly name = 'ApiError';

  constructor(
    /** Name of the google.rpc.Code, such as NOT_FOUND. */
    readonly code: string,
    message: string,
    /** Path of the wrong field of the request, such as "scene.grid.columns"; empty if the server names none. */
    readonly field = '',
    /** Stable name of the cause, such as TOKEN_EXPIRED; empty if the server names none. */
    readonly reason = '',
  ) {
    super(message);
  }
}

const kCodes = [
  'OK',
  'CANCELLED',
  'UNKNOWN',
  'INVALID_ARGUMENT',
  'DEADLINE_EXCEEDED',
  'NOT_FOUND',
  'ALREADY_EXISTS',
  'PERMISSION_DENIED',
  'RESOURCE_EXHAUSTED',
  'FAILED_PRECONDITION',
  'ABORTED',
  'OUT_OF_RANGE',
  'UNIMPLEMENTED',
  'INTERNAL',
  'UNAVAILABLE',
  'DATA_LOSS',
  'UNAUTHENTICATED',
];

/** The parts of google.rpc.Status, as JSON, that are used here. */
interface StatusJson {
  code?: number | string;
  message?: string;
  details?: { reason?: string; field_violations?: { field?: string }[] }[];
}

interface Answer {
  status: number;
  body: string;
}

/** Options of a request. */
interface Sending {
  signal?: AbortSignal;
  /** Receives the share of the request that has been sent, 0..1. */
  onProgress?: (part: number) => void;
}

// Makes every POST of the viewer. The server takes a login's cookie only with this header, which other sites cannot send.
async function post(path: string, body: string | Blob, { signal, onProgress }: Sending): Promise<Answer> {
  const headers: Record<string, string> = { 'x-kerf-csrf': '1' };
  if (typeof body === 'string') headers['content-type'] = 'application/json';
  try {
    if (onProgress) return await postTelling(path, body, headers, onProgress, signal);
    const response = await fetch(path, { method: 'POST', headers, body, signal });
    return { status: response.status, body: await response.text() };
  } catch (error) {
    throw unreachable(error as Error);
  }
}

// Uses XMLHttpRequest, because fetch() does not report how much of a body is sent.
function postTelling(
  path: string,
  body: string | Blob,
  headers: Record<string, string>,
  told: (part: number) => void,
  signal: AbortSignal | undefined,
): Promise<Answer> {
  return new Promise((resolve, reject) => {
    signal?.throwIfAborted();
    const request = new XMLHttpRequest();
    request.open('POST', path);
    for (const [name, value] of Object.entries(headers)) request.setRequestHeader(name, value);
    request.upload.onprogress = ({ loaded, total }) => told(total > 0 ? loaded / total : 0);
    request.onload = () => resolve({ status: request.status, body: request.responseText });
    request.onerror = () => reject(new Error('the connection was lost'));
    request.onabort = () => reject(new Error('cancelled'));
    signal?.addEventListener('abort', () => request.abort());
    request.send(body);
  });
}

function errorFromBody(status: number, body: string): ApiError {
  try {
    const { code, message, details } = JSON.parse(body) as StatusJson;
    const name = typeof code === 'number' ? kCodes[code] : code;
    const field = details?.flatMap((detail) => detail.field_violations ?? []).at(0)?.field;
    const reason = details?.find((detail) => detail.reason)?.reason;
    return new ApiError(name ?? 'UNKNOWN', message || `the server answered ${status}`, field, reason);
  } catch {
    return new ApiError(
      status === 404 ? 'UNIMPLEMENTED' : 'UNKNOWN',
      body.slice(0, 200) || `the server answered ${status}`,
    );
  }
}

function unreachable({ message }: Error): ApiError {
  return new ApiError('UNAVAILABLE', `the server cannot be reached (${message})`);
}

function isGood(status: number): boolean {
  return status >= 200 && status <= 299;
}

function messageOf<O extends DescMessage>(output: O, { status, body }: Answer): MessageShape<O> {
  if (!isGood(status)) throw errorFromBody(status, body);
  return fromJson(output, JSON.parse(body) as JsonValue, { ignoreUnknownFields: true });
}

let guard: ((refusal: ApiError) => Promise<void>) | undefined;
let numLogins = 0;

/**
 * Sets what is done when the server does not know who calls. The call waits for its promise, and is then repeated.
 * @param loggedIn  resolves once the user has logged in
 */
export function guardCalls(loggedIn: (refusal: ApiError) => Promise<void>): void {
  guard = loggedIn;
}

// Sends a request, and again after a login if the server does not know who calls.
async function answerTo(send: () => Promise<Answer>, signal: AbortSignal | undefined): Promise<Answer> {
  for (;;) {
    const numBefore = numLogins;
    const answer = await send();
    const refusal = answer.status === 401 ? errorFromBody(answer.status, answer.body) : undefined;
    if (!guard || refusal?.code !== 'UNAUTHENTICATED') return answer;
    // After a login in the meantime the user need not be asked.
    if (numBefore === numLogins) await unlessAborted(guard(refusal), signal);
  }
}

function unlessAborted(waiting: Promise<void>, signal: AbortSignal | undefined): Promise<void> {
  return new Promise((resolve, reject) => {
    const abort = () => reject(new ApiError('CANCELLED', 'cancelled'));
    if (signal?.aborted) return abort();
    signal?.addEventListener('abort', abort, { once: true });
    waiting.then(resolve, reject);
  });
}

/** Returns the JSON text of a request. */
export function requestBody<I extends DescMessage>(input: I, request: MessageInitShape<I>): string {
  return JSON.stringify(toJson(input, create(input, request)));
}

/** Options of a call. */
export interface CallOptions extends Sending {
  baseUrl?: string;
  /** False to fail where the server does not know who calls, in place of a wait for a login. */
  isGuarded?: boolean;
}

/**
 * Makes a unary call as protobuf JSON over POST /kerf.v1.Service/Method, to the server of this page.
 * @throws ApiError
 */
export async function call<I extends DescMessage, O extends DescMessage>(
  method: DescMethodUnary<I, O>,
  request: MessageInitShape<I>,
  options: CallOptions = {},
): Promise<MessageShape<O>> {
  const { baseUrl = '', isGuarded = true } = options;
  const path = `${baseUrl}/${method.parent.typeName}/${method.name}`;
  const sent = requestBody(method.input, request);
  const send = () => post(path, sent, options);
  return messageOf(method.output, await (isGuarded ? answerTo(send, options.signal) : send()));
}

/**
 * Returns the rights of this browser's login. Calls that were refused before are then repeated without asking the user.
 * @throws ApiError
 */
export async function presentAccess(): Promise<Access> {
  const access = await call(AccessService.method.getAccess, {}, { isGuarded: false });
  numLogins += 1;
  return access;
}

/**
 * Logs this browser in, by a cookie that scripts cannot read. Returns its rights.
 * @throws ApiError
 */
export async function logIn(credentials: { token: string } | { code: string }): Promise<Access> {
  const { status, body } = await post('/login', JSON.stringify(credentials), {});
  if (!isGood(status)) throw errorFromBody(status, body);
  return presentAccess().catch((error: ApiError) => {
    if (error.code !== 'UNAUTHENTICATED') throw error;
    throw new ApiError('FAILED_PRECONDITION', 'The browser does not keep the login: allow cookies for this page');
  });
}

/**
 * Logs this browser out, in all its tabs. Does nothing if it is not logged in.
 * @throws ApiError
 */
export async function logOut(): Promise<void> {
  const { status, body } = await post('/logout', '{}', {});
  if (!isGood(status) && status !== 401) throw errorFromBody(status, body);
}

/** Options of a long transfer; onProgress receives the share that has been sent or has arrived. */
export type TransferOptions = Required<Sending>;

/**
 * Sends a file, which may be larger than a request.
 * @param path  "/recordings?sheet=again"
 * @throws ApiError
 */
export async function sendFile<O extends DescMessage>(
  output: O,
  path: string,
  file: Blob,
  options: TransferOptions,
): Promise<MessageShape<O>> {
  return messageOf(output, await answerTo(() => post(path, file, options), options.signal));
}

/**
 * Fetches a file from the server; returns its content in parts.
 * @throws ApiError
 */
export async function fetchFile(path: string, { signal, onProgress }: TransferOptions): Promise<BlobPart[]> {
  try {
    let response!: Response;
    const ask = async () => {
      response = await fetch(path, { signal });
      return { status: response.status, body: response.ok ? '' : await response.text() };
    };
    const { status, body } = await answerTo(ask, signal);
    if (!isGood(status)) throw errorFromBody(status, body);
    const numBytes = Number(response.headers.get('content-length'));
    const parts: BlobPart[] = [];
    const reader = response.body!.getReader();
    let numRead = 0;
    for (;;) {
      const { done, value } = await reader.read();
      if (done) return parts;
      parts.push(value);
      numRead += value.length;
      if (numBytes > 0) onProgress(numRead / numBytes);
    }
  } catch (error) {
    throw error instanceof ApiError ? error : unreachable(error as Error);
  }
}
