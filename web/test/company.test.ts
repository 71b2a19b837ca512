import { create } from '@bufbuild/protobuf';
import { beforeEach, describe, expect, it } from 'vitest';
import { ActivitySchema, AudienceSchema, ViewerSchema } from '../src/gen/kerf/v1/stream_pb';
import type { Viewer } from '../src/gen/kerf/v1/stream_pb';
import { Arrivals } from '../src/ui/people/arrivals';
import { Company, pagesOf } from '../src/ui/people/company';

const viewer = (number: number, tokenId: string, more: Partial<Pick<Viewer, 'byLink' | 'pictures'>> = {}) =>
  create(ViewerSchema, { number, tokenId, ...more });
const kPictures = { pictures: true };

describe('pagesOf', () => {
  const numbers = (viewers: Viewer[], ownNumber: number, showsPictures = false) =>
    pagesOf({ viewers, ownNumber }, showsPictures).map(({ number }) => number);

  it('begins with this page and keeps the order of the others', () => {
    expect(numbers([viewer(3, 'alice'), viewer(5, 'bob'), viewer(9, 'carol')], 5)).toEqual([5, 3, 9]);
  });

  it('has a page once that gets pictures beside its frames, and a viewer of pictures alone', () => {
    const viewers = [viewer(1, 'alice'), viewer(2, 'bob'), viewer(3, 'bob', kPictures), viewer(4, 'carol', kPictures)];
    expect(numbers(viewers, 1)).toEqual([1, 2, 4]);
    // A guest of bob is another person.
    expect(numbers([...viewers, viewer(5, 'bob', { byLink: true, ...kPictures })], 1)).toEqual([1, 2, 4, 5]);
  });

  it('leaves out the pictures of this page, which are the newest, and only if it has some', () => {
    const viewers = [viewer(1, 'lab'), viewer(2, 'lab', kPictures), viewer(3, 'lab', kPictures)];
    expect(numbers(viewers, 1, false)).toEqual([1, 2, 3]);
    expect(numbers(viewers, 1, true)).toEqual([1, 2]);
  });

  it('does so on a server without tokens, where all have the same name', () => {
    const viewers = [viewer(1, ''), viewer(2, ''), viewer(3, '', kPictures), viewer(4, '', kPictures)];
    expect(numbers(viewers, 2, false)).toEqual([2, 1, 3]);
    expect(numbers(viewers, 2, true)).toEqual([2, 1]);
    // Those of pictures alone are never taken for this page.
    expect(numbers([viewer(1, ''), viewer(2, '', kPictures)], 1, false)).toEqual([1, 2]);
  });

  it('does without this page where it is not listed', () => {
    expect(numbers([viewer(1, 'alice'), viewer(2, 'bob')], 70, true)).toEqual([1, 2]);
  });
});

describe('Company', () => {
  let company: Company;
  const did = (tokenId: string, call: string, { byLink = false, unixUs = 0n } = {}) =>
    company.takeActivity(create(ActivitySchema, { tokenId, byLink, call, unixUs }));
  const changes = () => company.changes.map(({ tokenId, call, count }) => `${tokenId} ${call} ${count}`);

  beforeEach(() => (company = new Company()));

  it('knows who is there, and how many are not listed', () => {
    expect([company.isKnown, company.pages(false), company.numUnlisted]).toEqual([false, [], 0]);
    const viewers = [viewer(2, 'alice'), viewer(7, 'bob', { byLink: true })];
    company.takeAudience(create(AudienceSchema, { viewers, numViewers: 12, ownNumber: 7 }));
    expect([company.isKnown, company.numUnlisted, [...company.numbers]]).toEqual([true, 10, [2, 7]]);
    expect(company.pages(false).map(({ number }) => number)).toEqual([7, 2]);
    expect([company.viewer(2)?.tokenId, company.viewer(3)]).toEqual(['alice', undefined]);
    expect(viewers.map((each) => company.isSelf(each))).toEqual([false, true]);
  });

  it('counts the same change by the same person, and has the time of the last', () => {
    did('alice', 'CreateCut', { unixUs: 5n });
    did('alice', 'CreateCut', { unixUs: 8n });
    did('alice', 'UndoCut');
    did('alice', 'CreateCut', { unixUs: 9n });
    expect(changes()).toEqual(['alice CreateCut 2', 'alice UndoCut 1', 'alice CreateCut 1']);
    expect(company.changes.map(({ unixUs }) => unixUs)).toEqual([8n, 0n, 9n]);
  });

  it('tells a guest from the one who made the link', () => {
    did('bob', 'ResetSheet');
    did('bob', 'ResetSheet', { byLink: true });
    did('bob', 'ResetSheet', { byLink: true });
    expect(changes()).toEqual(['bob ResetSheet 1', 'bob ResetSheet 2']);
  });

  it('keeps the last 32 lines', () => {
    for (let i = 0; i < 40; ++i) did(`person-${i}`, 'CreateCut');
    for (let i = 0; i < 1000; ++i) did('last', 'GrabPoint');
    expect(changes()).toHaveLength(32);
    expect([changes()[0], changes().at(-1)]).toEqual(['person-9 CreateCut 1', 'last GrabPoint 1000']);
  });

  it('has another version after each change, and forgets all', () => {
    const versions = [company.version];
    const noted = (act: () => void) => {
      act();
      versions.push(company.version);
    };
    noted(() => did('alice', 'CreateCut'));
    noted(() => did('alice', 'CreateCut'));
    noted(() => company.takeAudience(create(AudienceSchema, { ownNumber: 1 })));
    noted(() => company.clear());
    expect(new Set(versions).size).toBe(5);
    expect([company.isKnown, company.changes]).toEqual([false, []]);
  });
});

describe('Arrivals', () => {
  it('does not announce a person whose next page is there before the last one is gone', () => {
    const arrivals = new Arrivals();
    const persons = new Set(['lab']);
    arrivals.saw(new Map([[1, 'lab']]), 0, persons);
    expect(arrivals.saw(new Map([[1, 'lab'], [2, 'lab']]), 10, persons)).toEqual([]);
    expect(arrivals.saw(new Map([[2, 'lab']]), 20, persons)).toEqual([]);
    expect(arrivals.saw(new Map([[2, 'lab'], [3, 'guest of lab'], [4, 'guest of lab']]), 30, persons)).toHaveLength(2);
  });

  const people = (...all: [number, string][]) => new Map(all);

  it('names who has joined since the last list, and none of the first one', () => {
    const arrivals = new Arrivals();
    expect(arrivals.saw(people([1, 'alice'], [2, 'bob']), 0)).toEqual([]);
    expect(arrivals.saw(people([1, 'alice'], [2, 'bob'], [3, 'carol'], [4, 'bob']), 10)).toEqual(['carol', 'bob']);
    expect(arrivals.saw(people([3, 'carol']), 20)).toEqual([]);
    arrivals.clear();
    expect(arrivals.saw(people([3, 'carol'], [5, 'dave']), 30)).toEqual([]);
  });

  it('does not name a person whose stream has begun again, in one list or in two, but one who comes back late', () => {
    const arrivals = new Arrivals();
    arrivals.saw(people([1, 'alice'], [2, 'bob']), 0);
    expect(arrivals.saw(people([1, 'alice'], [3, 'bob']), 10)).toEqual([]);
    arrivals.saw(people([1, 'alice']), 20);
    expect(arrivals.saw(people([1, 'alice'], [4, 'bob']), 4000)).toEqual([]);
    arrivals.saw(people([1, 'alice']), 5000);
    expect(arrivals.saw(people([1, 'alice'], [5, 'bob']), 10_001)).toEqual(['bob']);
    // Only as many as have left.
    arrivals.saw(people([1, 'alice']), 11_000);
    expect(arrivals.saw(people([1, 'alice'], [6, 'bob'], [7, 'bob']), 11_001)).toEqual(['bob']);
  });
});
