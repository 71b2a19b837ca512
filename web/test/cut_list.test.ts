import { create } from '@bufbuild/protobuf';
import { describe, expect, it } from 'vitest';
import { CutResultSchema, ListCutsResponse_EntrySchema, ScheduledCutsSchema, ScheduledCuts_State } from '../src/gen/kerf/v1/cuts_pb';
import { CutSchema, View_Layers } from '../src/gen/kerf/v1/scene_pb';
import { cutFacts, waitingText } from '../src/ui/cuts/cut_list';
import { CutMakers } from '../src/ui/cuts/cut_makers';
import { cutNumber, cutWords } from '../src/ui/cuts/cut_words';

const kCircle = { kind: { case: 'circle' as const, value: { center: { x: 0, y: 0 }, radiusM: 1 } } };

describe('words about cuts', () => {
  it('says what was drawn and through what', () => {
    const words = (init: Parameters<typeof create<typeof CutSchema>>[1]) => cutWords(create(CutSchema, init));
    expect(words({ curve: kCircle })).toBe('Circle');
    expect(words({ curve: kCircle, dash: [0.02, 0.01], widthM: 0.003 })).toBe('Circle, dashed, 3 mm wide');
    expect(words({ curve: kCircle, view: { layers: View_Layers.ALL } })).toBe('Circle, through every layer');
    const line = { kind: { case: 'polyline' as const, value: { points: [{ x: 0, y: 0 }, { x: 1, y: 0 }] } } };
    expect(words({ curve: line, view: {} })).toBe('Straight line, through what was seen');
    const subpaths = [{ segments: [] }, { segments: [] }];
    expect(words({ curve: { kind: { case: 'path', value: { subpaths } } } })).toBe('Drawing of 2 lines');
  });

  it('names the tick, what was removed and who made it', () => {
    const result = create(CutResultSchema, { tick: 1300n, removed: { areaM2: 0.0003 } });
    const entry = create(ListCutsResponse_EntrySchema, { cut: { curve: kCircle }, result });
    expect(cutFacts(entry, 'alice')).toBe('Circle · 3 cm² removed · tick 1,300 · by alice');
    expect(cutFacts(entry, undefined)).toBe('Circle · 3 cm² removed · tick 1,300');
  });

  it('tells waiting cuts from refused ones', () => {
    const cuts = [{}, {}];
    const waiting = create(ScheduledCutsSchema, { state: ScheduledCuts_State.WAITING, tick: 300n, cuts });
    const refused = create(ScheduledCutsSchema, { state: ScheduledCuts_State.REFUSED, tick: 200n, cuts });
    expect(waitingText([refused, waiting])).toBe('2 cuts at tick 300');
    expect(waitingText([refused])).toBe('');
  });

  it('takes the number from the name', () => {
    expect(cutNumber('sheets/demo/cuts/12')).toBe('12');
  });
});

describe('CutMakers', () => {
  const act = (tokenId: string, unixUs: number, call = 'CreateCut') => ({ call, tokenId, byLink: false, unixUs: BigInt(unixUs) });

  it('names the one person who has cut between two lists', () => {
    const makers = new CutMakers();
    makers.listed(['c/1'], makers.takeWaiting());
    makers.acted(act('alice', 1));
    makers.listed(['c/1', 'c/2'], makers.takeWaiting());
    expect([makers.of('c/1'), makers.of('c/2')]).toEqual([undefined, 'alice']);
  });

  it('names no one if several have cut, or if there are no names', () => {
    const makers = new CutMakers();
    makers.listed([], makers.takeWaiting());
    makers.acted(act('alice', 1));
    makers.acted(act('bob', 2));
    makers.listed(['c/1', 'c/2'], makers.takeWaiting());
    makers.acted(act('', 3));
    makers.listed(['c/1', 'c/2', 'c/3'], makers.takeWaiting());
    expect(['c/1', 'c/2', 'c/3'].map((cut) => makers.of(cut))).toEqual([undefined, undefined, undefined]);
  });

  it('knows the cuts of this page, and takes no change twice', () => {
    const makers = new CutMakers();
    makers.acted(act('alice', 1));
    makers.listed([], makers.takeWaiting());
    makers.made('c/1');
    makers.acted(act('me', 2));
    // A new connection tells of the last changes again.
    makers.acted(act('alice', 1));
    makers.acted(act('bob', 3, 'UndoCut'));
    makers.listed(['c/1', 'c/2'], makers.takeWaiting());
    expect([makers.of('c/1'), makers.of('c/2')]).toEqual(['you', 'me']);
    makers.clear();
    expect(makers.of('c/1')).toBeUndefined();
  });

  it('leaves a cut that comes back by a redo with whoever made it', () => {
    const makers = new CutMakers();
    makers.listed([], makers.takeWaiting());
    makers.acted(act('alice', 1));
    makers.listed(['c/1'], makers.takeWaiting());
    makers.listed([], makers.takeWaiting());
    makers.acted(act('bob', 2));
    makers.listed(['c/1', 'c/2'], makers.takeWaiting());
    expect([makers.of('c/1'), makers.of('c/2')]).toEqual(['alice', 'bob']);
  });
});
