import { vi } from 'vitest';

/** A call that waits for its answer. */
export interface HeldCall {
  /** "SetSheetPins" */
  method: string;
  /** As JSON. */
  request: { name?: string } & Record<string, unknown>;
}

/** A server that answers no call until it is released. */
export class HeldCalls {
  /** All, in their order. */
  readonly calls: HeldCall[] = [];
  private readonly answers: ((status: number) => void)[] = [];

  constructor() {
    vi.stubGlobal('fetch', (url: string, { body }: { body: string }) => {
      this.calls.push({ method: url.split('/').at(-1)!, request: JSON.parse(body) });
      return new Promise((resolve) =>
        this.answers.push((status) => resolve({ status, text: async () => '{}' })),
      );
    });
  }

  /** Answers the one that has waited longest, and waits until that has been taken. */
  answer(status = 200): Promise<unknown> {
    this.answers.shift()!(status);
    return new Promise((resolve) => setTimeout(resolve));
  }
}
