import { create, fromJson, toJson } from '@bufbuild/protobuf';
import type { DescMessage, DescMethodUnary, JsonValue, MessageInitShape, MessageShape } from '@bufbuild/protobuf';

/** A call that the server refused (or could not be reached for: code UNAVAILABLE). */
export class ApiError extends Error {
  override readonly name = 'ApiError';

  constructor(
    /** Name of the google.rpc.Code, such as NOT_FOUND. */
    readonly code: string,
    message: string,
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

function errorFromBody(status: number, body: string): ApiError {
  try {
    const { code, message } = JSON.parse(body) as { code?: number | string; message?: string };
    const name = typeof code === 'number' ? kCodes[code] : code;
    return new ApiError(name ?? 'UNKNOWN', message || `the server answered ${status}`);
  } catch {
    return new ApiError(
      status === 404 ? 'UNIMPLEMENTED' : 'UNKNOWN',
      body.slice(0, 200) || `the server answered ${status}`,
    );
  }
}

/**
 * One unary call as protobuf JSON over POST /kerf.v1.Service/Method, to the server that served this page.
 * @throws ApiError
 */
export async function call<I extends DescMessage, O extends DescMessage>(
  method: DescMethodUnary<I, O>,
  request: MessageInitShape<I>,
  options: { baseUrl?: string; signal?: AbortSignal } = {},
): Promise<MessageShape<O>> {
  let response: Response;
  let body: string;
  try {
    response = await fetch(`${options.baseUrl ?? ''}/${method.parent.typeName}/${method.name}`, {
      method: 'POST',
      headers: { 'content-type': 'application/json' },
      body: JSON.stringify(toJson(method.input, create(method.input, request))),
      signal: options.signal,
    });
    body = await response.text();
  } catch (error) {
    throw new ApiError('UNAVAILABLE', `the server cannot be reached (${(error as Error).message})`);
  }
  if (!response.ok) throw errorFromBody(response.status, body);
  return fromJson(method.output, JSON.parse(body) as JsonValue, { ignoreUnknownFields: true });
}
