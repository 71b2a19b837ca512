import { Vector3 } from 'three';
import type { Notifier } from '../notifier';
import type { CameraPlace, Stage } from '../scene/stage';
import type { OpenSheet } from '../sheet/open_sheet';
import { sheetId } from '../sheets';
import type { SheetLook } from './sheet_look';

/** The part of a link that is no sheet. */
export interface LinkedView {
  /** Undefined: the whole sheet is in view. */
  camera: CameraPlace | undefined;
  colors: 'cloth' | 'pieces' | 'strain';
  isWireframe: boolean;
  /** True if pictures drawn by the server are shown. */
  hasPictures: boolean;
}

const kParameters = ['camera', 'colors', 'wireframe', 'pictures'];
// Largest coordinate of a camera, metres.
const kFarthestM = 1e5;
const kDigits = 5;

/** Removes from an address what holds a view of its sheet. */
export function withoutView(url: URL): URL {
  kParameters.forEach((name) => url.searchParams.delete(name));
  return url;
}

/**
 * Returns the address that opens this view of a sheet. The camera's numbers are eye and target, x, y, z in metres.
 * @param page  address of the viewer; its other parameters and its fragment are left out
 */
export function viewAddress(page: string, sheetName: string, { camera, colors, isWireframe, hasPictures }: LinkedView): string {
  const url = new URL(page);
  const numbers = ({ x, y, z }: Vector3) => [x, y, z].map((metres) => Number(metres.toPrecision(kDigits)));
  const parameters = [`sheet=${encodeURIComponent(sheetId(sheetName))}`];
  if (camera) parameters.push(`camera=${[...numbers(camera.eye), ...numbers(camera.target)].join(',')}`);
  if (colors !== 'cloth') parameters.push(`colors=${colors}`);
  if (isWireframe) parameters.push('wireframe=1');
  if (hasPictures) parameters.push('pictures=1');
  return `${url.origin}${url.pathname}?${parameters.join('&')}`;
}

/** Reads a view from the query of an address; parts that are missing or wrong are as without a link. */
export function linkedView(query: string): LinkedView {
  const parameters = new URLSearchParams(query);
  const colors = parameters.get('colors');
  return {
    camera: cameraOf(parameters.get('camera') ?? ''),
    colors: colors === 'pieces' || colors === 'strain' ? colors : 'cloth',
    isWireframe: parameters.get('wireframe') === '1',
    hasPictures: parameters.get('pictures') === '1',
  };
}

function cameraOf(text: string): CameraPlace | undefined {
  const numbers = text.split(',').map((part) => (part.trim() === '' ? NaN : Number(part)));
  if (numbers.length !== 6 || !numbers.every((metres) => Math.abs(metres) <= kFarthestM)) return undefined;
  const [x, y, z, toX, toY, toZ] = numbers;
  if (x === toX && y === toY && z === toZ) return undefined;
  return { eye: new Vector3(x, y, z), target: new Vector3(toX, toY, toZ) };
}

/** The parts of the viewer that make up a view. */
export interface LinkingParts {
  readonly stage: Pick<Stage, 'place'>;
  readonly shown: { beginAt(place: CameraPlace): void };
  readonly live: Pick<OpenSheet, 'sheetName'>;
  readonly look: Pick<
    SheetLook,
    'isByPiece' | 'isByStrain' | 'isWireframe' | 'toggleByPiece' | 'toggleByStrain' | 'toggleWireframe'
  >;
  readonly imageMode: { readonly isOn: boolean; toggle(): Promise<void> };
  readonly notices: Notifier;
}

/** Opens the view in the page's address, and copies a link to the present one. */
export class ViewLink {
  private readonly view = linkedView(location.search);

  constructor(private readonly parts: LinkingParts) {}

  /** Sets camera and look. Call it before the sheet is opened. */
  begin(): void {
    const { shown, look } = this.parts;
    const { camera, colors, isWireframe } = this.view;
    if (camera) shown.beginAt(camera);
    if (colors === 'pieces') look.toggleByPiece();
    if (colors === 'strain') look.toggleByStrain();
    if (isWireframe) look.toggleWireframe();
  }

  /** Asks for the server's pictures if the address does. Call it once a sheet is open. */
  async follow(): Promise<void> {
    if (this.view.hasPictures && !this.parts.imageMode.isOn) await this.parts.imageMode.toggle();
  }

  async copy(): Promise<void> {
    const { stage, live, look, imageMode, notices } = this.parts;
    if (live.sheetName === '') {
      notices.notify('info', 'There is no sheet that a link could open');
      return;
    }
    const address = viewAddress(location.href, live.sheetName, {
      camera: stage.place,
      colors: look.isByPiece ? 'pieces' : look.isByStrain ? 'strain' : 'cloth',
      isWireframe: look.isWireframe,
      hasPictures: imageMode.isOn,
    });
    try {
      await navigator.clipboard.writeText(address);
      notices.notify('success', 'Link copied: it opens this sheet from here');
    } catch {
      // Browsers have no clipboard for pages without TLS.
      history.replaceState(null, '', address);
      notices.notify('info', 'The browser does not let the page copy: the link is in its address bar now');
    }
  }
}
