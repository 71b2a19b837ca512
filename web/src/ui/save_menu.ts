import { Scope } from '../gen/kerf/v1/access_service_pb';
import type { Reporter } from '../notifier';
import { meshFile } from '../scene/mesh_file';
import type { MeshFormat } from '../scene/mesh_file';
import { pictureOf } from '../scene/picture';
import type { Stage } from '../scene/stage';
import { drawStrainLegend } from '../scene/strain_legend';
import type { StrainLegend } from '../scene/strain_legend';
import type { OpenSheet, ShownState } from '../sheet/open_sheet';
import type { Rights } from './access/rights';
import { element, setText } from './dom';
import { fileName, saveFile } from './download';
import { Menu } from './menu';

/** The parts of the viewer from which files are made. */
export interface SavedParts {
  readonly stage: Pick<Stage, 'picture'>;
  readonly shown: Pick<ShownState, 'surface'>;
  readonly live: Pick<OpenSheet, 'sheetName'> & { readonly isWatched: boolean };
  readonly look: { readonly strainScale: { readonly legend: StrainLegend | undefined } };
  /** Pictures of the server. */
  readonly imageMode: { readonly isShown: boolean; readonly tick: number };
  readonly recording: { readonly isOn: boolean; start(): void; stop(): void };
  readonly replayBar: { readonly sheetName: string | undefined; choose(): void };
  readonly transfer: { readonly isOn: boolean };
  readonly rights: Pick<Rights, 'may'>;
  readonly notices: Reporter;
}

/**
 * Saves the shown sheet: pictures, meshes, recordings of frames. ServerRecordings handles the menu's items for the
 * server's recordings.
 */
export class SaveMenu {
  private readonly menu: Menu;
  private readonly record = element<HTMLButtonElement>('save-recording');

  constructor(private readonly parts: SavedParts) {
    const { recording, replayBar } = parts;
    this.menu = new Menu(element<HTMLButtonElement>('save-open'), element('save-menu'), () => this.opening());
    const on = (id: string, act: () => void) => element(id).addEventListener('click', act);
    on('save-png', () => void this.savePicture(1));
    on('save-png-2', () => void this.savePicture(2));
    on('save-obj', () => void this.saveMesh('obj'));
    on('save-glb', () => void this.saveMesh('glb'));
    on('save-recording', () => (recording.isOn ? recording.stop() : recording.start()));
    on('open-recording', () => replayBar.choose());
  }

  toggle(): void {
    this.menu.toggle();
  }

  private opening(): void {
    const { live, recording, rights, shown, transfer } = this.parts;
    setText(this.record.querySelector('span')!, recording.isOn ? 'Stop recording and save' : 'Record the frames');
    this.record.disabled = !live.isWatched;
    // Only a live sheet has a run, and one file is transferred at a time.
    element<HTMLButtonElement>('save-run').disabled = !live.isWatched || transfer.isOn;
    element<HTMLButtonElement>('play-run').disabled = transfer.isOn || !rights.may(Scope.ADMIN);
    for (const id of ['save-png', 'save-png-2', 'save-obj', 'save-glb']) {
      element<HTMLButtonElement>(id).disabled = shown.surface === undefined;
    }
  }

  private nameOf(tick: number, extension: string): string {
    const { live, replayBar } = this.parts;
    return fileName(replayBar.sheetName ?? live.sheetName, tick, extension);
  }

  private async savePicture(scale: number): Promise<void> {
    const { imageMode, look, notices, shown, stage } = this.parts;
    // Uses the picture's tick if one is shown, because the mesh is then older.
    const tick = imageMode.isShown ? imageMode.tick : (shown.surface?.mirror.tick ?? 0);
    const name = this.nameOf(tick, scale === 1 ? 'png' : `${scale}x.png`);
    const { legend } = look.strainScale;
    await notices.attempt(async () => {
      const drawn = stage.picture(scale);
      const blob = await pictureOf(drawn, (context) => legend && drawStrainLegend(context, legend, drawn.height, scale));
      notices.notify('success', saveFile([blob], name, 'image/png'));
    }, 'The picture was not saved: ');
  }

  private async saveMesh(format: MeshFormat): Promise<void> {
    const { notices, shown } = this.parts;
    const { surface } = shown;
    if (!surface) return;
    const name = this.nameOf(surface.mirror.tick, format);
    await notices.attempt(async () => {
      const { content, mediaType } = await meshFile(surface.mirror, name.replace(/\.\w+$/, ''), format);
      notices.notify('success', saveFile([content], name, mediaType));
    }, 'The mesh was not saved: ');
  }
}
