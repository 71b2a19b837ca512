import type { App } from '../app';
import { meshFile } from '../scene/mesh_file';
import type { MeshFormat } from '../scene/mesh_file';
import { pictureOf } from '../scene/picture';
import { drawStrainLegend } from '../scene/strain_legend';
import { element, setText } from './dom';
import { fileName, saveFile } from './download';
import { Menu } from './menu';

/** What is shown, as a file: pictures, meshes, recordings of frames. ServerRecordings has the items of the server’s recordings. */
export class SaveMenu {
  private readonly menu: Menu;
  private readonly record = element<HTMLButtonElement>('save-recording');

  constructor(private readonly app: App) {
    this.menu = new Menu(element<HTMLButtonElement>('save-open'), element('save-menu'), () => this.opening());
    const on = (id: string, act: () => void) => element(id).addEventListener('click', act);
    on('save-png', () => void this.savePicture(1));
    on('save-png-2', () => void this.savePicture(2));
    on('save-obj', () => void this.saveMesh('obj'));
    on('save-glb', () => void this.saveMesh('glb'));
    on('save-recording', () => (app.recording.isOn ? app.recording.stop() : app.recording.start()));
    on('open-recording', () => app.replayBar.choose());
  }

  toggle(): void {
    this.menu.toggle();
  }

  private opening(): void {
    const { app } = this;
    setText(this.record.querySelector('span')!, app.recording.isOn ? 'Stop recording and save' : 'Record the frames');
    this.record.disabled = app.watch === undefined;
    // Of a live sheet, and one file at a time.
    element<HTMLButtonElement>('save-run').disabled = app.watch === undefined || app.transfer.isOn;
    element<HTMLButtonElement>('play-run').disabled = app.transfer.isOn;
    for (const id of ['save-png', 'save-png-2', 'save-obj', 'save-glb']) {
      element<HTMLButtonElement>(id).disabled = app.surface === undefined;
    }
  }

  private nameOf(tick: number, extension: string): string {
    const { app } = this;
    return fileName(app.replayBar.sheetName ?? app.sheetName, tick, extension);
  }

  private async savePicture(scale: number): Promise<void> {
    const { app } = this;
    const { surface, imageMode } = app;
    // Beside pictures of the server the mesh comes seldom.
    const tick = imageMode.isShown ? imageMode.tick : (surface?.mirror.tick ?? 0);
    const name = this.nameOf(tick, scale === 1 ? 'png' : `${scale}x.png`);
    const { legend } = app.look.strainScale;
    await app.attempt(async () => {
      const drawn = app.stage.picture(scale);
      const blob = await pictureOf(drawn, (context) => legend && drawStrainLegend(context, legend, drawn.height, scale));
      app.notify('success', saveFile([blob], name, 'image/png'));
    }, 'The picture was not saved: ');
  }

  private async saveMesh(format: MeshFormat): Promise<void> {
    const { app } = this;
    const { surface } = app;
    if (!surface) return;
    const name = this.nameOf(surface.mirror.tick, format);
    await app.attempt(async () => {
      const { content, mediaType } = await meshFile(surface.mirror, name.replace(/\.\w+$/, ''), format);
      app.notify('success', saveFile([content], name, mediaType));
    }, 'The mesh was not saved: ');
  }
}
