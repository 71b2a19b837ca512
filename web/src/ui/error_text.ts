import { ApiError } from '../api';

// Remedies for refusals whose message names none, by code.
const kAdvice: Record<string, string> = {
  UNAVAILABLE: 'Check that kerfd is running; the viewer reconnects by itself',
  RESOURCE_EXHAUSTED: 'Try again in a moment, or request less',
  INTERNAL: 'See the server’s log',
  UNIMPLEMENTED: 'This server is older than the viewer: reload the page',
};

/** Describes an error and its remedy for people. */
export function errorText(error: Error): string {
  const advice = error instanceof ApiError ? kAdvice[error.code] : undefined;
  return advice ? `${error.message}. ${advice}` : error.message;
}
