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
  const percent = Math.floor((100 * tickBudgetUs) / tickAfterUs);
  return `This cut slows the sheet to ${percent} % of its speed: a tick then takes ${ms(tickAfterUs)} ms of the ${ms(tickBudgetUs)} ms available`;
}

/** Asks the server what a drawn cut would cost, once the drawing has settled, and one question at a time. */
export class CutForecast {
  warning = '';
  private timer = 0;
  private drawn = 0; // counts drawings: answers about older ones are late
  private isAsking = false;
  private request: (() => Request) | undefined;
  private circumstances = '';

  /** @param changed  called when the warning has changed */
  constructor(
    private readonly changed: () => void,
    private readonly tryCut = (request: Request) => call(CutService.method.createCut, request),
  ) {}

  /** @param request  says what would be cut, when it is asked; undefined while there is nothing to cut */
  ask(request: (() => Request) | undefined): void {
    clearTimeout(this.timer);
    const number = ++this.drawn;
    const { warning } = this;
    this.request = request;
    this.warning = '';
    if (warning) this.changed();
    if (request) this.wait(number, request);
  }

  /** Asks again where the same drawing no longer cuts the same. @param circumstances  name what that depends on */
  follow(circumstances: string): void {
    if (circumstances === this.circumstances) return;
    this.circumstances = circumstances;
    if (this.request) this.ask(this.request);
  }

  private wait(number: number, request: () => Request): void {
    this.timer = window.setTimeout(() => void this.find(number, request), kSettledMs);
  }

  // A cut that the server would refuse is refused when it is made, with the reason.
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
