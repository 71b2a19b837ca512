import { describe, expect, it } from 'vitest';
import { ApiError } from '../src/api';
import { Region_Edge } from '../src/gen/kerf/v1/conditions_pb';
import { Fidelity } from '../src/gen/kerf/v1/scene_pb';
import { formErrors, nameError, refusal } from '../src/ui/sheets/form_checks';
import type { NewSheet } from '../src/ui/sheets/new_sheet';

const kForm: NewSheet = {
  id: '',
  shape: 'grid',
  columns: 30,
  rows: 20,
  widthM: 3,
  heightM: 2,
  file: undefined,
  mesh: { unitM: 1, up: 'z', object: '', ignoresTexture: false },
  outline: undefined,
  outlineWidthM: 1,
  hang: 'flat',
  material: 'silk',
  fidelity: Fidelity.EXACT,
  pins: Region_Edge.LEFT,
  hasFloor: true,
  hasBall: true,
  isPaused: true,
};

function errorsOf(form: Partial<NewSheet>, hasDrawing = false, maxVertices = 500_000) {
  return Object.fromEntries(formErrors({ ...kForm, ...form }, hasDrawing, maxVertices));
}

describe('nameError', () => {
  it('takes what the server takes, and no name at all', () => {
    for (const id of ['', 'a', 'flag-2', 'a'.repeat(63)]) expect(nameError(id)).toBeUndefined();
  });

  it('says what a name is made of, and offers one', () => {
    const rule = 'Name: use small letters, digits and hyphens, beginning with a letter';
    expect(nameError('My Flag!')).toBe(`${rule}, such as my-flag`);
    expect(nameError('2nd')).toBe(`${rule}, such as nd`);
    expect(nameError('布')).toBe(rule);
    expect(nameError('a'.repeat(64))).toContain(`such as ${'a'.repeat(63)}`);
  });
});

describe('formErrors', () => {
  it('are none of a form that is right', () => {
    expect(errorsOf({})).toEqual({});
    expect(errorsOf({ shape: 'file', file: { name: 'a.obj', kind: 'obj', content: new Blob(['v']) }, columns: NaN })).toEqual({});
    expect(errorsOf({ shape: 'outline' }, true)).toEqual({});
  });

  it('are all there are, at once and without the protocol’s names', () => {
    const errors = errorsOf({ id: 'Not An Id', columns: 2000, rows: 2.5, widthM: -1, heightM: NaN });
    expect(errors).toEqual({
      id: 'Name: use small letters, digits and hyphens, beginning with a letter, such as not-an-id',
      columns: 'Columns: give a whole number from 2 to 1,000',
      rows: 'Rows: give a whole number from 2 to 1,000',
      width: 'Width: give a length above 0 m, at most 10,000 m',
      height: 'Height: give a length above 0 m, at most 10,000 m',
    });
  });

  it('say when the server has no room for so many vertices', () => {
    expect(errorsOf({ columns: 1000, rows: 1000 }).rows).toMatch(/1,000,000 vertices; the server accepts 500,000: use fewer/);
    expect(errorsOf({ columns: 1000, rows: 1000 }, false, Infinity)).toEqual({});
  });

  it('ask for a file with something in it, or for a drawing', () => {
    expect(errorsOf({ shape: 'file' })).toEqual({ file: 'Choose an OBJ or a PLY file' });
    const empty = { name: 'empty.obj', kind: 'obj' as const, content: new Blob([]) };
    expect(errorsOf({ shape: 'file', file: empty })).toEqual({ file: 'empty.obj is empty: choose another one' });
    expect(Object.keys(errorsOf({ shape: 'outline', outlineWidthM: 0 }))).toEqual(['outline', 'outline-width']);
  });
});

describe('refusal', () => {
  it('stands at its field in the user’s words', () => {
    const taken = new ApiError('ALREADY_EXISTS', 'a sheet "demo" already exists');
    expect(refusal(taken, { ...kForm, id: 'demo' })).toEqual(['id', 'A sheet named demo already exists']);
    const open = new ApiError('INVALID_ARGUMENT', 'outline.boundary is no closed line', 'scene.outline.boundary');
    expect(refusal(open, kForm)).toEqual(['outline', 'The drawing is no closed line']);
    const broken = new ApiError('INVALID_ARGUMENT', 'line 1: no number', 'scene.obj');
    expect(refusal(broken, kForm)).toEqual(['file', 'Line 1: no number']);
    expect(refusal(new Error('the connection was lost'), kForm)).toEqual(['', 'the connection was lost']);
  });
});
