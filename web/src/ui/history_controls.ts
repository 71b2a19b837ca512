import type { DescMethodUnary, MessageShape } from '@bufbuild/protobuf';
import { call } from '../api';
import { CutService } from '../gen/kerf/v1/cuts_pb';
import type { UndoCutRequestSchema, UndoResultSchema } from '../gen/kerf/v1/cuts_pb';
import type { Reporter } from '../notifier';
import type { OpenSheet } from '../sheet/open_sheet';

export type HistoryStep = 'undo' | 'redo';

// Says nothing about a reset, which SheetNews reports to every viewer.
function stepText(step: HistoryStep, { cuts, pieces, reset }: MessageShape<typeof UndoResultSchema>): string | undefined {
  if (reset) return undefined;
  const what = cuts.length === 1 ? 'Cut' : `${cuts.length} cuts`;
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
    this.isSending = true;
    for (let next = waiting.shift(); next; next = waiting.shift()) {
      // After a refusal the next steps would be refused too.
      if (!(await this.make(next))) waiting.length = 0;
    }
    this.isSending = false;
  }

  private async make({ step, sheetName: parent }: AskedStep): Promise<boolean> {
    const { undoCut, redoCut } = CutService.method;
    // The two requests have the same fields.
    const method = (step === 'undo' ? undoCut : redoCut) as DescMethodUnary<
      typeof UndoCutRequestSchema,
      typeof UndoResultSchema
    >;
    const refused = step === 'undo' ? 'Nothing was undone: ' : 'Nothing was redone: ';
    const result = await this.reporter.attempt(() => this.send(method, { parent }), refused);
    const text = result && stepText(step, result);
    if (text) this.reporter.notify('success', text);
    return result !== undefined;
  }
}
