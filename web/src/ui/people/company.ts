import type { Activity, Audience, Viewer } from '../../gen/kerf/v1/stream_pb';

/** One change, or the same change by the same person several times in a row. */
export interface Change extends Pick<Activity, 'tokenId' | 'byLink' | 'call'> {
  count: number;
  /** Time of the last one, microseconds since 1970. */
  unixUs: bigint;
}

// As many as a stream begins with.
const kMostChanges = 32;

function isSamePerson(one: Pick<Viewer, 'tokenId' | 'byLink'>, other: Pick<Viewer, 'tokenId' | 'byLink'>): boolean {
  return one.tokenId === other.tokenId && one.byLink === other.byLink;
}

/**
 * Returns the viewers of an audience with each page once, this page first. A page that shows pictures of the server has
 * two streams. So one stream of pictures is left out for each page of the same name.
 * @param showsPictures  true if this page does
 */
export function pagesOf({ viewers, ownNumber }: Pick<Audience, 'viewers' | 'ownNumber'>, showsPictures: boolean): Viewer[] {
  const own = viewers.find(({ number }) => number === ownNumber);
  const kept = new Set(viewers);
  const newestFirst = [...viewers].reverse();
  for (const page of viewers) {
    if (page.pictures) continue;
    if (page === own && !showsPictures) continue;
    const isItsPicture = (other: Viewer) => other.pictures && kept.has(other) && isSamePerson(page, other);
    const pictures = newestFirst.find(isItsPicture);
    if (pictures) kept.delete(pictures);
  }
  const others = viewers.filter((viewer) => kept.has(viewer) && viewer !== own);
  return own ? [own, ...others] : others;
}

/** Those who watch the live sheet, and the last changes to it, as the stream says. */
export class Company {
  /** Increases with each change of what is known here. */
  version = 0;

  private audience: Audience | undefined;
  private readonly grouped: Change[] = [];

  /** False until the stream has said who watches. */
  get isKnown(): boolean {
    return this.audience !== undefined;
  }

  /** The last changes, the oldest first. */
  get changes(): readonly Change[] {
    return this.grouped;
  }

  /** Viewer.number of each viewer that is listed. */
  get numbers(): ReadonlySet<number> {
    return new Set(this.audience?.viewers.map(({ number }) => number));
  }

  viewer(number: number): Viewer | undefined {
    return this.audience?.viewers.find((viewer) => viewer.number === number);
  }

  isSelf({ number }: Viewer): boolean {
    return number === this.audience?.ownNumber;
  }

  /** See pagesOf(). */
  pages(showsPictures: boolean): Viewer[] {
    return this.audience ? pagesOf(this.audience, showsPictures) : [];
  }

  /** Number of viewers that are not listed. */
  get numUnlisted(): number {
    const { audience } = this;
    return audience ? Math.max(0, audience.numViewers - audience.viewers.length) : 0;
  }

  takeAudience(audience: Audience): void {
    this.audience = audience;
    this.version += 1;
  }

  takeActivity({ tokenId, byLink, call, unixUs }: Activity): void {
    const last = this.grouped.at(-1);
    if (last && last.call === call && isSamePerson(last, { tokenId, byLink })) {
      last.count += 1;
      last.unixUs = unixUs;
    } else {
      this.grouped.push({ tokenId, byLink, call, count: 1, unixUs });
      if (this.grouped.length > kMostChanges) this.grouped.shift();
    }
    this.version += 1;
  }

  /** Forgets everything: the next stream begins with all of it. */
  clear(): void {
    this.audience = undefined;
    this.grouped.length = 0;
    this.version += 1;
  }
}
