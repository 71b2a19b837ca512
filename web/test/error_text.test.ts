import { describe, expect, it } from 'vitest';
import { ApiError } from '../src/api';
import { errorText } from '../src/ui/error_text';

describe('errorText', () => {
  it('says what to do where the server did not, without its codes', () => {
    expect(errorText(new ApiError('UNAVAILABLE', 'no connection'))).toBe(
      'no connection. Check that kerfd is running; the viewer reconnects by itself',
    );
    expect(errorText(new ApiError('NOT_FOUND', 'no sheet "a"'))).toBe('no sheet "a"');
  });

  it('leaves other errors as they are', () => {
    expect(errorText(new Error('odd'))).toBe('odd');
  });
});
