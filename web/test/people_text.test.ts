import { create } from '@bufbuild/protobuf';
import { describe, expect, it } from 'vitest';
import { AccessService, Scope } from '../src/gen/kerf/v1/access_service_pb';
import { CutService } from '../src/gen/kerf/v1/cuts_pb';
import { FileService } from '../src/gen/kerf/v1/files_pb';
import { InteractionService } from '../src/gen/kerf/v1/interaction_pb';
import { RenderService } from '../src/gen/kerf/v1/render_pb';
import { ServerService } from '../src/gen/kerf/v1/server_pb';
import { SheetService } from '../src/gen/kerf/v1/sheets_pb';
import { StoreService } from '../src/gen/kerf/v1/store_service_pb';
import { StreamService, ViewerSchema } from '../src/gen/kerf/v1/stream_pb';
import { changeText, hasWords, timeText } from '../src/ui/people/change_text';
import { joinedText, personLines, personName, summaryText } from '../src/ui/people/person_text';
import { readFileSync, readdirSync } from 'node:fs';

const kServices = [
  AccessService,
  CutService,
  FileService,
  InteractionService,
  RenderService,
  ServerService,
  SheetService,
  StoreService,
  StreamService,
];

describe('changeText', () => {
  const text = (call: string, count = 1, tokenId = 'alice', byLink = false) => changeText({ tokenId, byLink, call, count });

  it('has words for every call of every service', () => {
    const calls = kServices.flatMap(({ methods }) => methods.map(({ name }) => name));
    expect(calls.filter((call) => !hasWords(call))).toEqual([]);
    // All services are listed above.
    const folder = new URL('../../proto/kerf/v1/', import.meta.url);
    const sources = readdirSync(folder).map((name) => readFileSync(new URL(name, folder), 'utf8'));
    const inSources = sources.flatMap((source) => [...source.matchAll(/^ {2}rpc (\w+)\(/gm)].map(([, name]) => name));
    expect(calls.sort()).toEqual(inSources.sort());
  });

  it('says who did what, once and several times', () => {
    expect(text('CreateCut')).toBe('alice cut the sheet');
    expect(text('CreateCut', 7)).toBe('alice cut 7 times');
    expect(text('CreateCut', 2)).toBe('alice cut twice');
    expect(text('CreateCut', 1234)).toBe('alice cut 1,234 times');
    expect(text('ResetSheet', 1, 'bob', true)).toBe('guest of bob reset the sheet');
    expect(text('SetSheetWind', 3, '')).toBe('someone changed the wind 3 times');
    expect(text('UndoCut', 2)).toBe('alice undid 2 changes');
    expect(text('GrabPoint', 2)).toBe('alice pulled twice');
  });

  it('leaves no sign for the number, and no two spaces, in any text', () => {
    for (const { methods } of kServices) {
      for (const { name } of methods) {
        for (const count of [1, 2, 9]) expect(text(name, count)).toMatch(/^alice( [^\s#]+)+$/);
      }
    }
  });

  it('splits the name of a call that it does not know', () => {
    expect(text('DoThisNow')).toBe('alice called “do this now”');
    expect(text('SetHTTPPort', 2)).toBe('alice called “set http port” twice');
    expect(text('toString')).toBe('alice called “to string”');
  });
});

describe('timeText', () => {
  const at = new Date(2026, 4, 3, 14, 5, 9);
  const unixUs = BigInt(at.getTime()) * 1000n;

  it('has the time, and the day if it is another', () => {
    expect(timeText(unixUs, new Date(2026, 4, 3, 23, 59))).toBe('14:05');
    expect(timeText(unixUs, new Date(2026, 4, 4, 0, 1))).toBe('3 May, 14:05');
  });
});

describe('texts about people', () => {
  const viewer = (number: number, tokenId: string, scope: Scope, byLink = false, pictures = false) =>
    create(ViewerSchema, { number, tokenId, scope, byLink, pictures });
  const lines = (...pages: ReturnType<typeof viewer>[]) =>
    personLines(pages, ({ number }) => number === 1).map(({ name, detail, isMarked }) => [name, detail, isMarked]);

  it('name guests by their host, and all the same without tokens', () => {
    expect(personName({ tokenId: 'alice', byLink: false })).toBe('alice');
    expect(personName({ tokenId: 'alice', byLink: true })).toBe('guest of alice');
    expect(personName({ tokenId: '', byLink: false })).toBe('someone');
  });

  it('list each with the rights in the words of Access, and mark the user', () => {
    expect(
      lines(
        viewer(1, 'lab', Scope.ADMIN),
        viewer(2, 'alice', Scope.CUT),
        viewer(3, 'lab', Scope.VIEW, true),
        viewer(4, 'bob', Scope.VIEW, false, true),
      ),
    ).toEqual([
      ['lab', 'everything', true],
      ['alice', 'look and cut', false],
      ['guest of lab', 'look only', false],
      ['bob', 'look only, pictures only', false],
    ]);
  });

  it('have one line for those of one name and one right, but not for the user and others with the same token', () => {
    expect(
      lines(
        viewer(1, 'lab', Scope.CUT),
        viewer(2, 'lab', Scope.CUT),
        viewer(3, 'lab', Scope.CUT),
        viewer(4, 'lab', Scope.VIEW, true),
        viewer(5, 'lab', Scope.VIEW, true),
        viewer(6, 'lab', Scope.CUT, true),
      ),
    ).toEqual([
      ['lab', 'look and cut', true],
      ['lab, 2 times', 'look and cut', false],
      ['2 guests of lab', 'look only', false],
      ['guest of lab', 'look and cut', false],
    ]);
  });

  it('count the others on a server without tokens', () => {
    const open = (number: number, pictures = false) => viewer(number, '', Scope.ADMIN, false, pictures);
    expect(lines(open(1), open(2), open(3), open(4, true))).toEqual([
      ['You', '', false],
      ['2 others', '', false],
      ['1 other', 'pictures only', false],
    ]);
  });

  it('say how many are there, and who has joined', () => {
    expect([0, 1, 2].map(summaryText)).toEqual([
      'You are alone here.',
      'You and 1 other watch this sheet.',
      'You and 2 others watch this sheet.',
    ]);
    expect([[], ['alice'], ['alice', 'guest of bob'], ['someone', 'someone'], ['a', 'b', 'c', 'd']].map(joinedText)).toEqual([
      '',
      'alice has joined',
      'alice and guest of bob have joined',
      '2 others have joined',
      '4 others have joined',
    ]);
  });
});
