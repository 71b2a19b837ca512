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

/** The parts of the viewer that follow the sheet that is shown. */
export interface FollowingParts {
  readonly live: Pick<LiveSheet, 'sheetName' | 'isWatched' | 'open' | 'close' | 'refresh'>;
  readonly shown: Pick<ShownSheet, 'set' | 'clear' | 'hide'>;
  readonly tools: Pick<ToolChoice, 'choose'> & { readonly tool: { leave(): void } };
  readonly recording: Pick<RecordingControl, 'stop'>;
  readonly imageMode: Pick<ImageMode, 'follow' | 'leave' | 'close' | 'clear'>;
  readonly replayBar: Pick<ReplayBar, 'hasFile' | 'leave'>;
  readonly panels: Pick<SidePanels, 'open' | 'close'>;
  readonly connection: Pick<ConnectionChip, 'show'>;
}

/** Decides which sheet is shown: a live one, a recording in its place, or none. */
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

  /** Shows a live sheet, but not before the recording that is shown or read is closed. */
  offer(name: string): void {
    if (this.parts.replayBar.hasFile) this.parts.live.sheetName = name;
    else this.open(name);
  }

  /** Shows no live sheet and nothing of the last one. A recording that is shown or read stays. */
  close(): void {
    const { live, shown, imageMode, replayBar } = this.parts;
    live.sheetName = '';
    if (replayBar.hasFile) return;
    this.letGo();
    imageMode.clear();
    shown.hide();
  }

  /** Shows a recording in place of the live sheet, whose name stays. */
  showReplay(sheet: Sheet): void {
    const { shown, tools, imageMode, panels, connection } = this.parts;
    this.letGo();
    imageMode.leave();
    tools.choose('view');
    // The other panels are the live sheet's.
    if (panels.open !== 'sheets') panels.close();
    setLiveControls(false);
    shown.set(sheet);
    connection.show('replay', '');
  }

  /** Returns from a recording to the live sheet, if there is one; it may have been watched all the time. */
  leaveReplay(): void {
    const { live } = this.parts;
    if (live.isWatched) return;
    if (live.sheetName !== '') this.open(live.sheetName);
    else this.close();
  }

  // The last sheet stays in the picture until the next one comes.
  private letGo(): void {
    const { live, shown, tools, recording, imageMode } = this.parts;
    tools.tool.leave();
    recording.stop();
    live.close();
    imageMode.close();
    shown.clear();
  }
}
