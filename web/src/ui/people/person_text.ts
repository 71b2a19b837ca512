import type { Viewer } from '../../gen/kerf/v1/stream_pb';
import { countText } from '../../tools/cut_text';
import { scopeText } from '../access/access_text';

type Named = Pick<Viewer, 'tokenId' | 'byLink'>;

/** A line of the list of those who watch. */
export interface PersonLine {
  name: string;
  /** Rights and the like; may be empty. */
  detail: string;
  /** True if the line is to be marked as that of the user. */
  isMarked: boolean;
}

/** Returns the name that others read: "alice", "guest of alice"; "someone" on a server without tokens. */
export function personName({ tokenId, byLink }: Named): string {
  if (tokenId === '') return 'someone';
  return byLink ? `guest of ${tokenId}` : tokenId;
}

function detailText({ tokenId, scope, pictures }: Viewer): string {
  const rights = tokenId === '' ? '' : scopeText(scope);
  return [rights, pictures ? 'pictures only' : ''].filter((text) => text !== '').join(', ');
}

// The name of others who share a line.
function othersName({ tokenId, byLink }: Named, count: number): string {
  if (tokenId === '') return countText(count, 'other', 'others');
  if (count === 1) return personName({ tokenId, byLink });
  return byLink ? `${count} guests of ${tokenId}` : `${tokenId}, ${count} times`;
}

/**
 * Returns the lines of a list of viewers. Viewers with the same name and rights share a line: "2 others".
 * @param pages  this page first; see pagesOf()
 */
export function personLines(pages: readonly Viewer[], isSelf: (viewer: Viewer) => boolean): PersonLine[] {
  const alike = new Map<string, Viewer[]>();
  for (const page of pages) {
    const key = [isSelf(page), page.tokenId, page.byLink, detailText(page)].join('\n');
    alike.set(key, [...(alike.get(key) ?? []), page]);
  }
  return [...alike.values()].map((group) => {
    const [page] = group;
    const detail = detailText(page);
    if (!isSelf(page)) return { name: othersName(page, group.length), detail, isMarked: false };
    const isNamed = page.tokenId !== '';
    return { name: isNamed ? personName(page) : 'You', detail, isMarked: isNamed };
  });
}

/** Says in one line who is there: "You and 2 others watch this sheet". */
export function summaryText(numOthers: number): string {
  if (numOthers === 0) return 'You are alone here.';
  return `You and ${countText(numOthers, 'other', 'others')} watch this sheet.`;
}

/** Says who has joined: "alice and guest of bob have joined"; empty without names. */
export function joinedText(names: readonly string[]): string {
  if (names.length === 0) return '';
  if (names.length === 1) return `${names[0]} has joined`;
  const areFew = names.length <= 3 && new Set(names).size === names.length;
  const who = areFew ? `${names.slice(0, -1).join(', ')} and ${names.at(-1)}` : `${names.length} others`;
  return `${who} have joined`;
}
