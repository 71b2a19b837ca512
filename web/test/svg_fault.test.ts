import { describe, expect, it } from 'vitest';
import { faultText } from '../src/geometry/svg_fault';

describe('faultText', () => {
  it('names the line that a browser names', () => {
    const chromium = 'This page contains the following errors:error on line 3 at column 7: Premature end of data';
    const firefox = 'XML Parsing Error: no element found\nLocation: about:blank\nLine Number 12, Column 1:';
    expect(faultText(chromium)).toBe('is broken: its text ends early or has an error in line 3');
    expect(faultText(firefox)).toBe('is broken: its text ends early or has an error in line 12');
  });

  it('does without one', () => {
    expect(faultText('')).toBe('is broken: its text ends early or has an error');
  });
});
