import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import { SettingsFollower } from '../src/stream/settings_follower';

describe('SettingsFollower', () => {
  let answers: ((isFetched: boolean) => void)[];
  let follower: SettingsFollower;

  /** Answers the fetch under way. */
  async function answer(isFetched = true): Promise<void> {
    answers.at(-1)!(isFetched);
    await vi.advanceTimersByTimeAsync(0);
  }

  beforeEach(() => {
    vi.useFakeTimers({ toFake: ['setTimeout', 'clearTimeout', 'performance'] });
    vi.advanceTimersByTime(10_000);
    answers = [];
    follower = new SettingsFollower(() => new Promise((resolve) => answers.push(resolve)));
  });

  afterEach(() => {
    vi.useRealTimers();
  });

  it('fetches a first version at once and one that it has not again', async () => {
    follower.saw(3);
    expect(answers).toHaveLength(1);
    await answer();
    follower.saw(3);
    await vi.advanceTimersByTimeAsync(5000);
    expect(answers).toHaveLength(1);
  });

  it('fetches the second of two quick changes although no frame follows', async () => {
    follower.saw(1);
    await answer();
    await vi.advanceTimersByTimeAsync(60);
    follower.saw(2);
    expect(answers).toHaveLength(1);
    await vi.advanceTimersByTimeAsync(189);
    expect(answers).toHaveLength(1);
    await vi.advanceTimersByTimeAsync(1);
    expect(answers).toHaveLength(2);
  });

  it('fetches a change that came while a fetch was under way', async () => {
    follower.saw(1);
    follower.saw(2);
    await vi.advanceTimersByTimeAsync(400);
    expect(answers).toHaveLength(1);
    await answer();
    expect(answers).toHaveLength(2);
  });

  it('fetches at most four times a second, however often the settings change', async () => {
    for (let version = 1; version < 100; ++version) {
      follower.saw(version);
      await answer();
      await vi.advanceTimersByTimeAsync(10);
    }
    expect(answers).toHaveLength(4);
  });

  it('tries a failed fetch again, without another frame, until it succeeds', async () => {
    follower.saw(1);
    await answer(false);
    await vi.advanceTimersByTimeAsync(1000);
    expect(answers).toHaveLength(2);
    await answer(false);
    await vi.advanceTimersByTimeAsync(1000);
    expect(answers).toHaveLength(3);
    await answer();
    await vi.advanceTimersByTimeAsync(5000);
    expect(answers).toHaveLength(3);
  });

  it('forgets timer, version and answer under way when it is reset', async () => {
    follower.saw(1);
    await answer();
    follower.saw(2);
    follower.reset();
    await vi.advanceTimersByTimeAsync(5000);
    expect(answers).toHaveLength(1);
    follower.saw(1);
    follower.reset();
    follower.saw(1);
    // The answer to the fetch before reset(), which another sheet's settings must not be taken for.
    answers[1](true);
    await vi.advanceTimersByTimeAsync(1000);
    expect(answers).toHaveLength(3);
  });
});
