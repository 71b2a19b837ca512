import type { DescMethodUnary } from '@bufbuild/protobuf';
import { call } from '../api';
import { CutService } from '../gen/kerf/v1/cuts_pb';
import type { UndoCutRequestSchema, UndoResult, UndoResultSchema } from '../gen/kerf/v1/cuts_pb';
import type { Reporter } from '../notifier';
import type { OpenSheet } from '../sheet/open_sheet';

export type HistoryStep = 'undo' | 'redo';

// Says nothing about a reset, which SheetNews reports to every viewer.
function stepText(step: HistoryStep, { cuts, pieces, reset }: UndoResult): string | undefined {
  return reset ? undefined : undoneText(step, cuts.length, pieces);
}

function undoneText(step: HistoryStep, numCuts: number, pieces: number): string {
  const what = numCuts === 1 ? 'Cut' : `${numCuts} cuts`;
  return `${what} ${step === 'undo' ? 'undone' : 'redone'}: ${pieces} ${pieces === 1 ? 'piece' : 'pieces'}`;
}

// Most steps that wait while one is in progress; more presses are unintended.
const kMostWaiting = 8;

interface AskedStep {
  step: HistoryStep;
  sheetName: string;
}

/**
 * Undo and redo of the sheet's cuts. Each press is a step: one is in progress, and others wait in order. A held key has
 * at most one step waiting, so that it does not fill the server's queue and stops when released.
 */
export class HistoryControls {
  private isSending = false;
  private readonly waiting: AskedStep[] = [];

  constructor(
    private readonly live: Pick<OpenSheet, 'sheetName'>,
    private readonly reporter: Reporter,
    private readonly send: typeof call = call,
  ) {}

  /** @param isHeld  true for repeats of a held key */
  async run(step: HistoryStep, isHeld = false): Promise<void> {
    const { waiting } = this;
    if (waiting.length >= (isHeld ? 1 : kMostWaiting)) return;
    waiting.push({ step, sheetName: this.live.sheetName });
    if (this.isSending) return;
    await this.drain();
  }

  /**
   * Undoes cuts, the newest first, until this one is undone.
   * @param cut        its name
   * @param mostSteps  number of steps that may be undone
   */
  async undoTo(cut: string, mostSteps: number): Promise<void> {
    if (this.isSending) return;
    const { sheetName } = this.live;
    this.isSending = true;
    let numCuts = 0;
    let pieces = 0;
    for (let step = 0; step < mostSteps; ++step) {
      const result = await this.request({ step: 'undo', sheetName });
      if (!result) break;
      [numCuts, pieces] = [numCuts + result.cuts.length, result.pieces];
      if (result.cuts.includes(cut)) break;
    }
    if (numCuts > 0) this.reporter.notify('success', undoneText('undo', numCuts, pieces));
    await this.drain();
  }

  private async drain(): Promise<void> {
    const { waiting } = this;
    this.isSending = true;
    for (let next = waiting.shift(); next; next = waiting.shift()) {
      // After a refusal the next steps would be refused too.
      if (!(await this.make(next))) waiting.length = 0;
    }
    this.isSending = false;
  }

  private async make(asked: AskedStep): Promise<boolean> {
    const result = await this.request(asked);
    const text = result && stepText(asked.step, result);
    if (text) this.reporter.notify('success', text);
    return result !== undefined;
  }

  private request({ step, sheetName: parent }: AskedStep): Promise<UndoResult | undefined> {
    const { undoCut, redoCut } = CutService.method;
    // The two requests have the same fields.
    const method = (step === 'undo' ? undoCut : redoCut) as DescMethodUnary<
      typeof UndoCutRequestSchema,
      typeof UndoResultSchema
    >;
    const refused = step === 'undo' ? 'Nothing was undone: ' : 'Nothing was redone: ';
    return this.reporter.attempt(() => this.send(method, { parent }), refused);
  }
}
