import { beforeEach, describe, expect, it } from 'vitest';
import { NewestAnswer } from '../src/newest_answer';

describe('NewestAnswer', () => {
  // The questions asked, in their order, each with what answers it or lets it fail.
  let asked: { answer(value: string): Promise<unknown>; fail(): Promise<unknown> }[];
  let taken: string[];
  let answers: NewestAnswer<string>;

  /** A promise that the test settles, listed with the questions. */
  function held(): Promise<string> {
    return new Promise((resolve, reject) => {
      const settled = () => new Promise((done) => setTimeout(done));
      asked.push({
        answer: (value) => (resolve(value), settled()),
        fail: () => (reject(new Error('no server')), settled()),
      });
    });
  }

  beforeEach(() => {
    asked = [];
    taken = [];
    answers = new NewestAnswer(held, (value) => taken.push(value));
  });

  it('takes answers in the order of asking, and drops one that comes after a later one', async () => {
    const isTaken = [answers.fetch(), answers.fetch(), answers.fetch()];
    await asked[1].answer('second');
    await asked[0].answer('first');
    await asked[2].answer('third');
    expect(taken).toEqual(['second', 'third']);
    expect(await Promise.all(isTaken)).toEqual([true, true, true]);
  });

  it('drops what was asked before a change was answered, whichever answer comes first', async () => {
    const isBefore = answers.fetch();
    const isAfter = answers.refresh();
    await asked[0].answer('before');
    expect(taken).toEqual([]);
    await asked[1].answer('after');
    expect(taken).toEqual(['after']);
    expect(await Promise.all([isBefore, isAfter])).toEqual([true, true]);
  });

  it('says that nothing was taken where the question after a change fails', async () => {
    const isTaken = [answers.fetch(), answers.refresh()];
    await asked[0].answer('before');
    await asked[1].fail();
    expect(taken).toEqual([]);
    expect(await Promise.all(isTaken)).toEqual([false, false]);
  });

  it('waits for what was asked last before it says that a dropped answer was replaced', async () => {
    let isTold = false;
    void answers.refresh().then(() => (isTold = true));
    void answers.refresh();
    await asked[0].answer('the first change');
    expect(isTold).toBe(false);
    await asked[1].answer('both changes');
    expect([isTold, taken]).toEqual([true, ['both changes']]);
  });

  it('takes what answers a command, and asks once more in place of what was asked while it was under way', async () => {
    const command = answers.command(held);
    const isTaken = answers.fetch();
    await asked[0].answer('paused');
    await asked[1].answer('running');
    expect(taken).toEqual(['paused']);
    await asked[2].answer('paused, with new pins');
    await command;
    expect([taken, await isTaken]).toEqual([['paused', 'paused, with new pins'], true]);
  });

  it('asks once more where a command is answered after a later change', async () => {
    const command = answers.command(held);
    void answers.refresh();
    await asked[0].answer('stepped, before the pins');
    await asked[1].answer('pins');
    expect(taken).toEqual([]);
    await asked[2].answer('stepped, with the pins');
    await command;
    expect(taken).toEqual(['stepped, with the pins']);
  });

  it('takes nothing of a command that failed', async () => {
    const command = answers.command(async () => undefined);
    void answers.fetch();
    await asked[0].answer('as before');
    await command;
    expect(taken).toEqual(['as before']);
  });
});
