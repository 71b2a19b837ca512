import { describe, expect, it } from 'vitest';
import { ApiError } from '../src/api';
import { errorText } from '../src/ui/error_text';

describe('errorText', () => {
  it('says what to do where the server did not, and ends with the code', () => {
    expect(errorText(new ApiError('UNAVAILABLE', 'no connection'))).toMatch(/^no connection\. .*kerfd.*\(UNAVAILABLE\)$/);
    expect(errorText(new ApiError('NOT_FOUND', 'no sheet "a"'))).toBe('no sheet "a" (NOT_FOUND)');
  });

  it('leaves other errors as they are', () => {
    expect(errorText(new Error('odd'))).toBe('odd');
  });
});
