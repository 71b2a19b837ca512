import type { MessageInitShape } from '@bufbuild/protobuf';
import { call } from '../api';
import { CutService } from '../gen/kerf/v1/cuts_pb';
import type { CreateCutRequestSchema, CutResult } from '../gen/kerf/v1/cuts_pb';

type Request = MessageInitShape<typeof CreateCutRequestSchema>;

// A drawing that changes is not asked about.
const kSettledMs = 400;

/** Says what the server expects of a cut, where that ends real time; else nothing. */
export function forecastText({ tickBeforeUs, tickAfterUs, tickBudgetUs }: CutResult): string {
  if (!(tickBeforeUs <= tickBudgetUs && tickAfterUs > tickBudgetUs)) return '';
  const ms = (us: number) => Number((us / 1000).toPrecision(2));
  const speed = Number((tickBudgetUs / tickAfterUs).toPrecision(1));
  return `This cut slows the sheet to ${speed} × real time: a step takes ${ms(tickAfterUs)} ms then and has ${ms(tickBudgetUs)}`;
}

/** Asks the server what a drawn cut would cost, once the drawing has settled. */
export class CutForecast {
  warning = '';
  private timer = 0;
  private asked = 0; // counts questions: answers to older ones are late

  /** @param changed  called when the warning has changed */
  constructor(
    private readonly changed: () => void,
    private readonly tryCut = (request: Request) => call(CutService.method.createCut, request),
  ) {}

  /** @param request  what would be cut; undefined while there is nothing to cut */
  ask(request: Request | undefined): void {
    clearTimeout(this.timer);
    const number = ++this.asked;
    this.warning = '';
    if (!request) return;
    this.timer = window.setTimeout(() => void this.find(number, request), kSettledMs);
  }

  // A cut that the server would refuse is refused when it is made, with the reason.
  private async find(number: number, request: Request): Promise<void> {
    const result = await this.tryCut({ ...request, validateOnly: true }).catch(() => undefined);
    if (!result || number !== this.asked) return;
    this.warning = forecastText(result);
    if (this.warning) this.changed();
  }
}
