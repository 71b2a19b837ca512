import type { Sheet } from '../gen/kerf/v1/sheets_pb';
import type { LiveSheet } from '../sheet/live_sheet';
import type { ShownSheet } from '../sheet/shown_sheet';
import type { ConnectionChip } from './connection_chip';
import { setLiveControls } from './dom';
import type { ImageMode } from './image_mode';
import type { RecordingControl } from './recording_control';
import type { ReplayBar } from './replay_bar';
import type { SidePanels } from './side_panels';
import type { ToolChoice } from './tool_choice';

/** The parts of the viewer that change with the shown sheet. */
export interface FollowingParts {
  readonly live: Pick<LiveSheet, 'sheetName' | 'isWatched' | 'open' | 'close' | 'refresh'>;
  readonly shown: Pick<ShownSheet, 'set' | 'clear' | 'hide'>;
  readonly tools: Pick<ToolChoice, 'choose'> & { readonly tool: { leave(): void } };
  readonly recording: Pick<RecordingControl, 'stop'>;
  readonly imageMode: Pick<ImageMode, 'follow' | 'leave' | 'close' | 'clear'>;
  readonly replayBar: Pick<ReplayBar, 'hasFile' | 'leave'>;
  readonly panels: Pick<SidePanels, 'open' | 'close'>;
  readonly connection: Pick<ConnectionChip, 'show'>;
  readonly people: { clear(): void };
}

/** Switches the shown sheet: a live one, a recording in its place, or none. */
export class SheetOpener {
  constructor(private readonly parts: FollowingParts) {}

  /**
   * Shows a live sheet.
   * @param name  sheets/{sheet}
   */
  open(name: string): void {
    const { live, imageMode, replayBar } = this.parts;
    this.letGo();
    replayBar.leave();
    live.open(name);
    imageMode.follow();
    void live.refresh();
  }

  /** Shows a live sheet at once or, if a recording is shown or being read, after it is closed. */
  offer(name: string): void {
    if (this.parts.replayBar.hasFile) this.parts.live.sheetName = name;
    else this.open(name);
  }

  /** Shows no live sheet and removes the last one. A recording that is shown or being read stays. */
  close(): void {
    const { live, shown, imageMode, replayBar } = this.parts;
    live.sheetName = '';
    if (replayBar.hasFile) return;
    this.letGo();
    imageMode.clear();
    shown.hide();
  }

  /** Shows a recording in place of the live sheet; live.sheetName stays. */
  showReplay(sheet: Sheet): void {
    const { shown, tools, imageMode, panels, connection } = this.parts;
    this.letGo();
    imageMode.leave();
    tools.choose('view');
    // Closes panels that concern the live sheet.
    if (panels.open !== 'sheets') panels.close();
    setLiveControls(false);
    shown.set(sheet);
    connection.show('replay', '');
  }

  /** Returns from a recording to the live sheet, if there is one and it is not watched already. */
  leaveReplay(): void {
    const { live } = this.parts;
    if (live.isWatched) return;
    if (live.sheetName !== '') this.open(live.sheetName);
    else this.close();
  }

  // Ends all that belongs to the last sheet, which stays visible until the next arrives.
  private letGo(): void {
    const { live, shown, tools, recording, imageMode, people } = this.parts;
    tools.tool.leave();
    recording.stop();
    live.close();
    people.clear();
    imageMode.close();
    shown.clear();
  }
}
