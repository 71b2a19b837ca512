import { create, fromJson, toJson } from '@bufbuild/protobuf';
import type { DescMessage, DescMethodUnary, JsonValue, MessageInitShape, MessageShape } from '@bufbuild/protobuf';

/** A call that the server refused (or could not be reached for: code UNAVAILABLE). */
export class ApiError extends Error {
  override readonly name = 'ApiError';

  constructor(
    /** Name of the google.rpc.Code, such as NOT_FOUND. */
    readonly code: string,
    message: string,
    /** Path of the request's field that is wrong, such as "scene.grid.columns"; empty where none is named. */
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

/** google.rpc.Status as JSON, what of it is used. */
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

// fetch() does not tell how much of a body is sent.
function postTelling(url: string, body: string, told: (part: number) => void): Promise<Answer> {
  return new Promise((resolve, reject) => {
    const request = new XMLHttpRequest();
    request.open('POST', url);
    request.setRequestHeader('content-type', 'application/json');
    request.upload.onprogress = ({ loaded, total }) => told(total > 0 ? loaded / total : 0);
    request.onload = () => resolve({ status: request.status, body: request.responseText });
    request.onerror = () => reject(new Error('the connection broke'));
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

/** A request as it is sent. */
export function requestBody<I extends DescMessage>(input: I, request: MessageInitShape<I>): string {
  return JSON.stringify(toJson(input, create(input, request)));
}

/**
 * One unary call as protobuf JSON over POST /kerf.v1.Service/Method, to the server that served this page.
 * @param options.onProgress  told the part of the request that is sent, 0..1
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
    answer = await (onProgress ? postTelling(url, sent, onProgress) : post(url, sent, signal));
  } catch (error) {
    throw new ApiError('UNAVAILABLE', `the server cannot be reached (${(error as Error).message})`);
  }
  if (answer.status < 200 || answer.status > 299) throw errorFromBody(answer.status, answer.body);
  return fromJson(method.output, JSON.parse(answer.body) as JsonValue, { ignoreUnknownFields: true });
}
