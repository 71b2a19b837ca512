import type { DescMethodUnary, MessageShape } from '@bufbuild/protobuf';
import { call } from '../api';
import { CutService } from '../gen/kerf/v1/cuts_pb';
import type { UndoCutRequestSchema, UndoResultSchema } from '../gen/kerf/v1/cuts_pb';
import type { Viewer } from '../tools/tool';

export type HistoryStep = 'undo' | 'redo';

function told(step: HistoryStep, { cuts, pieces }: MessageShape<typeof UndoResultSchema>): string {
  const what = cuts.length === 1 ? 'Cut' : `${cuts.length} cuts`;
  return `${what} ${step === 'undo' ? 'undone' : 'made again'}: ${pieces} ${pieces === 1 ? 'piece' : 'pieces'}`;
}

/**
 * Undo and redo of the sheet's cuts: one under way and the newest that was asked for meanwhile, so that two quick presses are
 * two steps, and a held key does not fill the server's queue.
 */
export class HistoryControls {
  private isSending = false;
  private waiting: { step: HistoryStep; sheetName: string } | undefined;

  constructor(
    private readonly viewer: Pick<Viewer, 'sheetName' | 'attempt' | 'notify'>,
    private readonly send: typeof call = call,
  ) {}

  async run(step: HistoryStep): Promise<void> {
    this.waiting = { step, sheetName: this.viewer.sheetName };
    if (this.isSending) return;
    this.isSending = true;
    while (this.waiting) {
      const { step: next, sheetName }: { step: HistoryStep; sheetName: string } = this.waiting;
      this.waiting = undefined;
      // After a refusal the next would only be refused as well.
      if (!(await this.make(next, sheetName))) this.waiting = undefined;
    }
    this.isSending = false;
  }

  private async make(step: HistoryStep, parent: string): Promise<boolean> {
    const { undoCut, redoCut } = CutService.method;
    // The two requests have the same fields.
    const method = (step === 'undo' ? undoCut : redoCut) as DescMethodUnary<
      typeof UndoCutRequestSchema,
      typeof UndoResultSchema
    >;
    const result = await this.viewer.attempt(() => this.send(method, { parent }));
    if (result) this.viewer.notify('success', told(step, result));
    return result !== undefined;
  }
}
