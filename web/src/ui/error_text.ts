import { ApiError } from '../api';

// What to do about a refusal that the server's own words do not already say.
const kAdvice: Record<string, string> = {
  UNAVAILABLE: 'Look whether kerfd runs; the viewer connects again by itself',
  RESOURCE_EXHAUSTED: 'Try again in a moment, or ask for less',
  INTERNAL: 'The server’s log says more',
  UNIMPLEMENTED: 'This server is older than the viewer: reload the page',
};

/** An error in words: what went wrong, what to do, and in brackets the code. */
export function errorText(error: Error): string {
  if (!(error instanceof ApiError)) return error.message;
  const advice = kAdvice[error.code];
  return `${error.message}${advice ? `. ${advice}` : ''} (${error.code})`;
}
