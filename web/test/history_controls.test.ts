import { create } from '@bufbuild/protobuf';
import { describe, expect, it } from 'vitest';
import type { call } from '../src/api';
import { UndoResultSchema } from '../src/gen/kerf/v1/cuts_pb';
import { HistoryControls } from '../src/ui/history_controls';

describe('HistoryControls', () => {
  const notices: string[] = [];
  const sent: string[] = [];
  let answer: (cuts: number) => void = () => {};
  let refuse: (reason: string) => void = () => {};
  const send = ((method: { name: string }, request: { parent: string }) =>
    new Promise((resolve, reject) => {
      sent.push(`${method.name} ${request.parent}`);
      answer = (cuts) =>
        resolve(create(UndoResultSchema, { cuts: Array(cuts).fill('sheets/a/cuts/1'), pieces: cuts }));
      refuse = (reason) => reject(new Error(reason));
    })) as unknown as typeof call;
  const viewer = {
    sheetName: 'sheets/a',
    notify: (kind: string, text: string) => void notices.push(`${kind}: ${text}`),
    attempt: async <T>(run: () => Promise<T>, what: string) => {
      try {
        return await run();
      } catch (error) {
        notices.push(`error: ${what}${(error as Error).message}`);
        return undefined;
      }
    },
  };

  // Until the next call has been sent.
  const settled = () => new Promise((resolve) => setTimeout(resolve));

  it('makes every press a step, in the order of the presses, and no more than anybody means', async () => {
    const controls = new HistoryControls(viewer, viewer, send);
    const run = controls.run('undo');
    await controls.run('undo');
    await controls.run('redo');
    for (let i = 0; i < 20; ++i) await controls.run('undo');
    for (let i = 0; i < 9; ++i) {
      answer(1);
      await settled();
    }
    await run;
    const undo = 'UndoCut sheets/a';
    expect(sent.splice(0)).toEqual([undo, undo, 'RedoCut sheets/a', ...Array(6).fill(undo)]);
    expect(notices.splice(0)).toHaveLength(9);
  });

  it('makes one more of a held key while a call is under way, and none after a refusal', async () => {
    const controls = new HistoryControls(viewer, viewer, send);
    const run = controls.run('undo');
    for (let i = 0; i < 5; ++i) await controls.run('undo', true);
    answer(1);
    await settled();
    expect(sent.length).toBe(2);
    await controls.run('redo');
    refuse('the sheet has no cut to undo');
    await run;
    expect(sent.splice(0)).toEqual(['UndoCut sheets/a', 'UndoCut sheets/a']);
    expect(notices.splice(0)).toEqual([
      'success: Cut undone: 1 piece',
      'error: Nothing was undone: the sheet has no cut to undo',
    ]);
  });

  it('sends one call at a time and tells what came of it', async () => {
    const controls = new HistoryControls(viewer, viewer, send);
    const first = controls.run('undo');
    answer(1);
    await first;
    const second = controls.run('redo');
    answer(3);
    await second;
    const third = controls.run('undo');
    refuse('the sheet has no cut to undo');
    await third;
    const fourth = controls.run('redo');
    answer(1);
    await fourth;
    expect(sent).toEqual(['UndoCut sheets/a', 'RedoCut sheets/a', 'UndoCut sheets/a', 'RedoCut sheets/a']);
    expect(notices).toEqual([
      'success: Cut undone: 1 piece',
      'success: 3 cuts redone: 3 pieces',
      'error: Nothing was undone: the sheet has no cut to undo',
      'success: Cut redone: 1 piece',
    ]);
  });

  it('undoes down to a cut, no further than asked, and says so once', async () => {
    notices.length = sent.length = 0;
    const controls = new HistoryControls(viewer, viewer, send);
    const downTo = async (cut: string, steps: number, answers: number) => {
      const run = controls.undoTo(cut, steps);
      for (let i = 0; i < answers; ++i) {
        answer(2);
        await settled();
      }
      await run;
      return sent.splice(0).length;
    };
    // The answers name sheets/a/cuts/1, so the first of them ends it.
    expect(await downTo('sheets/a/cuts/1', 5, 1)).toBe(1);
    expect(await downTo('sheets/a/cuts/7', 3, 3)).toBe(3);
    expect(notices.splice(0)).toEqual(['success: 2 cuts undone: 2 pieces', 'success: 6 cuts undone: 2 pieces']);
    const refused = controls.undoTo('sheets/a/cuts/1', 3);
    const pressed = controls.run('redo');
    refuse('it is too old');
    await settled();
    answer(1);
    await Promise.all([refused, pressed]);
    expect(sent.splice(0)).toEqual(['UndoCut sheets/a', 'RedoCut sheets/a']);
    expect(notices.splice(0)).toEqual(['error: Nothing was undone: it is too old', 'success: Cut redone: 1 piece']);
  });
});
