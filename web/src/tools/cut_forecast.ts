import type { MessageInitShape } from '@bufbuild/protobuf';
import { call } from '../api';
import { CutService } from '../gen/kerf/v1/cuts_pb';
import type { CreateCutRequestSchema, CutResult } from '../gen/kerf/v1/cuts_pb';

type Request = MessageInitShape<typeof CreateCutRequestSchema>;

// Time without changes after which the server is asked about a drawing.
const kSettledMs = 400;

/** Returns a warning if the sheet is too slow for real time after a cut and was not before; else an empty text. */
export function forecastText({ tickBeforeUs, tickAfterUs, tickBudgetUs }: CutResult): string {
  if (!(tickBeforeUs <= tickBudgetUs && tickAfterUs > tickBudgetUs)) return '';
  const ms = (us: number) => Number((us / 1000).toPrecision(2));
  const percent = Math.floor((100 * tickBudgetUs) / tickAfterUs);
  return `This cut slows the sheet to ${percent} % of its speed: a tick then takes ${ms(tickAfterUs)} ms of the ${ms(tickBudgetUs)} ms available`;
}

/**
 * Asks the server how much time ticks would take after a drawn cut. It asks once the drawing has settled, one question
 * at a time.
 */
export class CutForecast {
  warning = '';
  private timer = 0;
  private drawn = 0; // counts drawings; answers about older ones are ignored
  private isAsking = false;
  private request: (() => Request) | undefined;
  private circumstances = '';

  /** @param changed  called when the warning has changed */
  constructor(
    private readonly changed: () => void,
    private readonly tryCut = (request: Request) => call(CutService.method.createCut, request),
  ) {}

  /** @param request  makes the request when it is needed; undefined while there is nothing to cut */
  ask(request: (() => Request) | undefined): void {
    clearTimeout(this.timer);
    const number = ++this.drawn;
    const { warning } = this;
    this.request = request;
    this.warning = '';
    if (warning) this.changed();
    if (request) this.wait(number, request);
  }

  /**
   * Asks again if the same drawing would now cut differently.
   * @param circumstances  text that changes with all that the cut depends on besides the drawing
   */
  follow(circumstances: string): void {
    if (circumstances === this.circumstances) return;
    this.circumstances = circumstances;
    if (this.request) this.ask(this.request);
  }

  private wait(number: number, request: () => Request): void {
    this.timer = window.setTimeout(() => void this.find(number, request), kSettledMs);
  }

  // Ignores refusals: the server refuses the cut again, with the reason, when it is made.
  private async find(number: number, request: () => Request): Promise<void> {
    if (this.isAsking) return this.wait(number, request);
    this.isAsking = true;
    const result = await this.tryCut({ ...request(), validateOnly: true }).catch(() => undefined);
    this.isAsking = false;
    if (!result || number !== this.drawn) return;
    this.warning = forecastText(result);
    if (this.warning) this.changed();
  }
}
