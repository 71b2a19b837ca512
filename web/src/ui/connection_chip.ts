import type { ConnectionState } from '../stream/connection';
import { element, setText } from './dom';

/** `replay`: a recording is shown. `out`: the user is logged out. */
export type ShownState = ConnectionState | 'replay' | 'out';

interface StateOfConnection {
  readonly state: ConnectionState;
  /** Reason of the state, for people; empty when all is well. */
  readonly detail: string;
}

/** The connections that the chip shows. */
export interface ConnectedParts {
  /** `watch`: the connection of the mesh; undefined without a live sheet. */
  readonly live: { readonly watch: StateOfConnection | undefined };
  /** `trouble`: the connection of the server's pictures; undefined while all is well. */
  readonly imageMode: { readonly trouble: StateOfConnection | undefined };
  readonly replayBar: { readonly isOpen: boolean };
  readonly session: { readonly isOut: boolean };
}

const kStateText: Record<ShownState, string> = {
  connecting: 'Connecting',
  live: 'Live',
  lost: 'Connection lost',
  ended: 'Ended',
  replay: 'Playing a recording',
  out: 'Logged out',
};

/** Shows the state of the connections in the header. */
export class ConnectionChip {
  constructor(private readonly parts: ConnectedParts) {}

  /**
   * Shows that the user is logged out, or else the state of the mesh's connection; if that is live, but pictures have
   * trouble, theirs.
   */
  update(): void {
    const { live, imageMode, session } = this.parts;
    if (session.isOut) return this.show('out', 'log in to continue');
    if (!live.watch) return;
    const { state, detail } = (live.watch.state === 'live' && imageMode.trouble) || live.watch;
    this.show(state, detail);
  }

  /**
   * Shows a state; while a recording is shown, only the state 'replay'.
   * @param detail  see ConnectionEvents.onState()
   */
  show(state: ShownState, detail: string): void {
    // A recording needs no server, so states of connections do not matter.
    if (this.parts.replayBar.isOpen && state !== 'replay') return;
    const chip = element('connection');
    chip.dataset.state = state;
    setText(chip.querySelector('b')!, kStateText[state]);
    const line = element('connection-detail');
    line.hidden = detail === '';
    setText(line, detail);
  }
}
