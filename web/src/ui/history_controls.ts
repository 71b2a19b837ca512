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

/** Undo and redo of the sheet's cuts, one at a time: a held key does not fill the server's queue. */
export class HistoryControls {
  private isSending = false;

  constructor(
    private readonly viewer: Pick<Viewer, 'sheetName' | 'attempt' | 'notify'>,
    private readonly send: typeof call = call,
  ) {}

  async run(step: HistoryStep): Promise<void> {
    if (this.isSending) return;
    this.isSending = true;
    const { undoCut, redoCut } = CutService.method;
    // The two requests have the same fields.
    const method = (step === 'undo' ? undoCut : redoCut) as DescMethodUnary<
      typeof UndoCutRequestSchema,
      typeof UndoResultSchema
    >;
    const result = await this.viewer.attempt(() => this.send(method, { parent: this.viewer.sheetName }));
    this.isSending = false;
    if (result) this.viewer.notify('success', told(step, result));
  }
}
