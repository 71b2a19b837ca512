import { create, fromJson, toJson } from '@bufbuild/protobuf';
import type { DescMessage, DescMethodUnary, JsonValue, MessageInitShape, MessageShape } from '@bufbuild/protobuf';

/** A call that the server refused. The code is UNAVAILABLE if the server could not be reached. */
export class ApiError extends Error {
  override readonly name = 'ApiError';

  constructor(
    /** Name of the google.rpc.Code, such as NOT_FOUND. */
    readonly code: string,
    message: string,
    /** Path of the wrong field of the request, such as "scene.grid.columns"; empty if the server names none. */
    readonly field = '',
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
  details?: { field_violations?: { field?: string }[] }[];
}

interface Answer {
  status: number;
  body: string;
}

async function post(url: string, body: string, signal: AbortSignal | undefined): Promise<Answer> {
  const headers = { 'content-type': 'application/json' };
  const response = await fetch(url, { method: 'POST', headers, body, signal });
  return { status: response.status, body: await response.text() };
}

// Uses XMLHttpRequest, because fetch() does not report how much of a body is sent.
function postTelling(
  url: string,
  body: string | Blob,
  told: (part: number) => void,
  signal: AbortSignal | undefined,
): Promise<Answer> {
  return new Promise((resolve, reject) => {
    signal?.throwIfAborted();
    const request = new XMLHttpRequest();
    request.open('POST', url);
    if (typeof body === 'string') request.setRequestHeader('content-type', 'application/json');
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
    return new ApiError(name ?? 'UNKNOWN', message || `the server answered ${status}`, field);
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

function messageOf<O extends DescMessage>(output: O, { status, body }: Answer): MessageShape<O> {
  if (status < 200 || status > 299) throw errorFromBody(status, body);
  return fromJson(output, JSON.parse(body) as JsonValue, { ignoreUnknownFields: true });
}

/** Returns the JSON text of a request. */
export function requestBody<I extends DescMessage>(input: I, request: MessageInitShape<I>): string {
  return JSON.stringify(toJson(input, create(input, request)));
}

/**
 * Makes a unary call as protobuf JSON over POST /kerf.v1.Service/Method, to the server of this page.
 * @param options.onProgress  receives the share of the request that has been sent, 0..1
 * @throws ApiError
 */
export async function call<I extends DescMessage, O extends DescMessage>(
  method: DescMethodUnary<I, O>,
  request: MessageInitShape<I>,
  options: { baseUrl?: string; signal?: AbortSignal; onProgress?: (part: number) => void } = {},
): Promise<MessageShape<O>> {
  const { baseUrl = '', signal, onProgress } = options;
  const url = `${baseUrl}/${method.parent.typeName}/${method.name}`;
  const sent = requestBody(method.input, request);
  let answer: Answer;
  try {
    answer = await (onProgress ? postTelling(url, sent, onProgress, signal) : post(url, sent, signal));
  } catch (error) {
    throw unreachable(error as Error);
  }
  return messageOf(method.output, answer);
}

/** Options of a long transfer. */
export interface TransferOptions {
  signal: AbortSignal;
  /** Receives the share that has been sent or has arrived, 0..1. */
  onProgress: (part: number) => void;
}

/**
 * Sends a file, which may be larger than a request.
 * @param path  "/recordings?sheet=again"
 * @throws ApiError
 */
export async function sendFile<O extends DescMessage>(
  output: O,
  path: string,
  file: Blob,
  { signal, onProgress }: TransferOptions,
): Promise<MessageShape<O>> {
  let answer: Answer;
  try {
    answer = await postTelling(path, file, onProgress, signal);
  } catch (error) {
    throw unreachable(error as Error);
  }
  return messageOf(output, answer);
}

/**
 * Fetches a file from the server; returns its content in parts.
 * @throws ApiError
 */
export async function fetchFile(path: string, { signal, onProgress }: TransferOptions): Promise<BlobPart[]> {
  try {
    const response = await fetch(path, { signal });
    if (!response.ok) throw errorFromBody(response.status, await response.text());
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
