import type { ConnectionState } from '../stream/connection';
import { element, setText } from './dom';

/** `replay`: a recording is shown. */
export type ShownState = ConnectionState | 'replay';

const kStateText: Record<ShownState, string> = {
  connecting: 'Connecting',
  live: 'Live',
  lost: 'Connection lost',
  ended: 'Ended',
  replay: 'Playing a recording',
};

/** @param detail  see ConnectionEvents.onState() */
export function showState(state: ShownState, detail: string): void {
  const chip = element('connection');
  chip.dataset.state = state;
  setText(chip.querySelector('b')!, kStateText[state]);
  const line = element('connection-detail');
  line.hidden = detail === '';
  setText(line, detail);
}
