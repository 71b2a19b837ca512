import { ApiError } from '../../api';
import { errorText } from '../error_text';
import { formField } from './new_sheet';
import type { NewSheet } from './new_sheet';
import { isId, nearestId } from './sheet_ids';

/** Faults of the form by field name; '' stands for the form as a whole. */
export type FormErrors = ReadonlyMap<string, string>;

// Limits of server/core/scene/sheet_config.cc: vertices per side, and length in metres.
const kMostOfASide = 1000;
const kLongestM = 10_000;

/** Describes the fault of a name; undefined if the name is valid, or empty, so that the server chooses one. */
export function nameError(id: string): string | undefined {
  if (id === '' || isId(id)) return undefined;
  const nearest = nearestId(id);
  const example = nearest === '' ? '' : `, such as ${nearest}`;
  return `Name: use small letters, digits and hyphens, beginning with a letter${example}`;
}

function countError(what: string, count: number): string | undefined {
  const isFine = Number.isInteger(count) && count >= 2 && count <= kMostOfASide;
  return isFine ? undefined : `${what}: give a whole number from 2 to ${kMostOfASide.toLocaleString('en')}`;
}

function lengthError(what: string, metres: number): string | undefined {
  const isFine = metres > 0 && metres <= kLongestM;
  return isFine ? undefined : `${what}: give a length above 0 m, at most ${kLongestM.toLocaleString('en')} m`;
}

function fileError({ file }: NewSheet): string | undefined {
  if (!file) return 'Choose an OBJ or a PLY file';
  return file.content.size === 0 ? `${file.name} is empty: choose another one` : undefined;
}

function verticesError(count: number, most: number): string | undefined {
  if (!(count > most)) return undefined;
  const [has, takes] = [count, most].map((number) => number.toLocaleString('en'));
  return `The sheet would have ${has} vertices; the server accepts ${takes}: use fewer rows or columns`;
}

/**
 * Returns all faults for which the server would refuse the form and that the page can find itself.
 * @param hasDrawing   true if an outline was chosen
 * @param maxVertices  the server's limit for a sheet; Infinity if it is not known
 */
export function formErrors(form: NewSheet, hasDrawing: boolean, maxVertices: number): FormErrors {
  const { shape, columns, rows } = form;
  const found: [string, string | undefined][] = [['id', nameError(form.id)]];
  if (shape === 'file') found.push(['file', fileError(form)]);
  if (shape === 'outline') {
    found.push(['outline', hasDrawing ? undefined : 'Choose an SVG file with a closed line']);
    found.push(['outline-width', lengthError('Width', form.outlineWidthM)]);
  }
  if (shape === 'grid') {
    const sides = [countError('Columns', columns), countError('Rows', rows)];
    found.push(['columns', sides[0]], ['rows', sides[1] ?? (sides[0] ? undefined : verticesError(columns * rows, maxVertices))]);
    found.push(['width', lengthError('Width', form.widthM)], ['height', lengthError('Height', form.heightM)]);
  }
  return new Map(found.filter((entry): entry is [string, string] => entry[1] !== undefined));
}

const kLabels: Record<string, string> = {
  id: 'Name',
  columns: 'Columns',
  rows: 'Rows',
  width: 'Width',
  height: 'Height',
  file: 'The file',
  outline: 'The drawing',
  material: 'The material',
  pins: 'Held at',
};

/** Returns the form's field that a refusal of the server concerns, and the refusal in words of the form. */
export function refusal(error: Error, form: NewSheet): [field: string, text: string] {
  if (!(error instanceof ApiError)) return ['', errorText(error)];
  if (error.code === 'ALREADY_EXISTS') return ['id', `A sheet named ${form.id} already exists`];
  const field = formField(error.field) ?? '';
  // "outline.boundary is open" -> "The drawing is open".
  const text = errorText(error).replace(/^[a-z]\w*(\.[\w[\]]+)+/, kLabels[field] ?? 'The sheet');
  return [field, `${text.charAt(0).toUpperCase()}${text.slice(1)}`];
}
