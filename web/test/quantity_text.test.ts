import { describe, expect, it } from 'vitest';
import { parseQuantity, plainText, siText } from '../src/ui/quantity_text';

describe('siText', () => {
  it('takes the prefix that reads best', () => {
    expect(siText(1.5e5, 'Pa')).toBe('150 kPa');
    expect(siText(6.9e10, 'Pa')).toBe('69 GPa');
    expect(siText(1.6e-5, 'm')).toBe('16 µm');
    expect(siText(0, 's')).toBe('0 s');
    expect(siText(1e-12, 'N m')).toBe('0.001 nN m');
  });
});

describe('parseQuantity', () => {
  it.each([
    ['150 kPa', 1.5e5],
    ['150k', 1.5e5],
    ['1.5e5', 1.5e5],
    [' .5 MPa ', 5e5],
    ['1,000 GPa', 1e12],
    ['0', 0],
    ['-3', -3],
  ])('reads %s', (text, value) => {
    expect(parseQuantity(text, 'Pa', true)).toBe(value);
  });

  it('tells metres and thousandths apart, and takes what keyboards have', () => {
    expect(parseQuantity('0.5 m', 'm', true)).toBe(0.5);
    expect(parseQuantity('0.5 mm', 'm', true)).toBe(5e-4);
    expect(parseQuantity('500 um', 'm', true)).toBe(5e-4);
    expect(parseQuantity('16 μm', 'm', true)).toBe(1.6e-5);
    expect(parseQuantity('9 uNm', 'N m', true)).toBe(9e-6);
    expect(parseQuantity('400 kg/m3', 'kg/m³', false)).toBe(400);
    expect(parseQuantity('0.3', '', false)).toBe(0.3);
  });

  it.each(['', 'kPa', 'soft', '1 2', '0,5', '1,30', '5 mm', '5 kN', '1e999', '--1', '.'])('refuses %s', (text) => {
    expect(parseQuantity(text, 'Pa', true)).toBeUndefined();
  });

  it('takes no prefix of a unit that has none', () => {
    expect(parseQuantity('4 k', 'kg/m³', false)).toBeUndefined();
    expect(parseQuantity('4 Pa', '', false)).toBeUndefined();
  });

  it('reads back what is written', () => {
    for (const value of [0, 1e-15, 1.23e-10, 1e-7, 4.56e-4, 0.5, 3, 999, 1300, 7.89e6, 1e12]) {
      expect(parseQuantity(siText(value, 'N m'), 'N m', true)).toBeCloseTo(value, 10 - Math.log10(value + 1e-18));
      expect(parseQuantity(plainText(value, '/s'), '/s', false)).toBe(Number(value.toPrecision(3)));
    }
  });
});
