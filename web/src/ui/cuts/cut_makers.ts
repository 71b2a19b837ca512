import type { Activity } from '../../gen/kerf/v1/stream_pb';
import { personName } from '../people/person_text';

export type Act = Pick<Activity, 'call' | 'tokenId' | 'byLink' | 'unixUs'>;

/**
 * Knows who made which cut, as far as that is certain. The list of cuts has no names and the stream's changes have no
 * cuts. So a cut that is new in the list was made by the one person who has cut since the list before.
 */
export class CutMakers {
  private readonly makers = new Map<string, string>();
  private readonly seen = new Set<string>();
  private readonly waiting = new Set<string>();
  private hasListed = false;
  private newestUs = 0n;

  /** Notes a cut that this page made. */
  made(cut: string): void {
    this.makers.set(cut, 'you');
  }

  /** Takes a change that the stream reports. A stream begins with older ones, which were taken before. */
  acted({ call, tokenId, byLink, unixUs }: Act): void {
    if (unixUs <= this.newestUs) return;
    this.newestUs = unixUs;
    if (call === 'CreateCut' || call === 'CreateCuts') this.waiting.add(personName({ tokenId, byLink }));
  }

  /** Returns those who have cut by now, for listed() once the list that is asked for next has come. */
  takeWaiting(): readonly string[] {
    const people = [...this.waiting];
    this.waiting.clear();
    return people;
  }

  /** @param people  as of takeWaiting() before the list was asked for */
  listed(cuts: readonly string[], people: readonly string[]): void {
    const fresh = cuts.filter((cut) => !this.seen.has(cut) && !this.makers.has(cut));
    cuts.forEach((cut) => this.seen.add(cut));
    const [person] = people;
    if (this.hasListed && people.length === 1 && person !== 'someone') {
      fresh.forEach((cut) => this.makers.set(cut, person));
    }
    this.hasListed = true;
  }

  of(cut: string): string | undefined {
    return this.makers.get(cut);
  }

  /** Forgets all, because another sheet is opened. */
  clear(): void {
    this.makers.clear();
    this.seen.clear();
    this.waiting.clear();
    this.hasListed = false;
    this.newestUs = 0n;
  }
}
