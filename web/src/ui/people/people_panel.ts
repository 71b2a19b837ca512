import type { Access } from '../../gen/kerf/v1/access_service_pb';
import type { Notifier } from '../../notifier';
import type { OpenSheet } from '../../sheet/open_sheet';
import { sheetId } from '../../sheets';
import { copyField } from '../access/copy_field';
import { element, make, setText } from '../dom';
import type { Panel } from '../side_panels';
import { changeText, timeText } from './change_text';
import type { Company } from './company';
import { personLines, summaryText } from './person_text';
import type { PersonLine } from './person_text';

/** The parts of the viewer that this panel uses. */
export interface PeoplePanelParts {
  readonly company: Company;
  readonly live: Pick<OpenSheet, 'sheetName'>;
  readonly notices: Notifier;
  /** True if this page shows pictures of the server. */
  showsPictures(): boolean;
  /** Opens the form for links. */
  share(): void;
}

/** Shows who watches the sheet and what they did last. The count on its button is shown also while it is closed. */
export class PeoplePanel implements Panel {
  private readonly count = element('people-count');
  private readonly summary = element('people-summary');
  private readonly list = element('people-list');
  private readonly changes = element('people-changes');
  private readonly address = element<HTMLInputElement>('people-address');
  private isOpen = false;
  private shown = '';

  constructor(private readonly parts: PeoplePanelParts) {
    element('people-share').addEventListener('click', () => parts.share());
    element('people-copy').addEventListener('click', () => void copyField(this.address, 'The address is copied', parts.notices));
  }

  opened(): void {
    this.isOpen = true;
    this.address.value = `${location.origin}/?sheet=${sheetId(this.parts.live.sheetName)}`;
    this.shown = '';
    this.update();
  }

  closed(): void {
    this.isOpen = false;
  }

  /**
   * Offers links if the server makes some, else the address of the sheet.
   * @param access  undefined: the user is logged out
   */
  show(access: Access | undefined): void {
    element('people-share').hidden = !access?.asksForTokens;
    element('people-open').hidden = access === undefined || access.asksForTokens;
  }

  /** Shows the newest state. It is called at each animation frame, and cheap if nothing has changed. */
  update(): void {
    const { company } = this.parts;
    const showsPictures = this.parts.showsPictures();
    const state = `${company.version} ${showsPictures} ${this.isOpen}`;
    if (state === this.shown) return;
    this.shown = state;
    const pages = company.pages(showsPictures);
    const numOthers = Math.max(0, pages.length + company.numUnlisted - 1);
    this.count.hidden = numOthers === 0;
    const word = make('span', { className: 'visually-hidden' }, numOthers === 1 ? ' other' : ' others');
    this.count.replaceChildren(numOthers > 99 ? '99+' : String(numOthers), word);
    if (!this.isOpen) return;
    setText(this.summary, company.isKnown ? summaryText(numOthers) : 'Not connected to the sheet.');
    this.list.replaceChildren(...personLines(pages, (viewer) => company.isSelf(viewer)).map(personItem));
    setText(element('people-rest'), company.numUnlisted > 0 ? `and ${company.numUnlisted} more` : '');
    this.showChanges();
  }

  private showChanges(): void {
    const { changes } = this.parts.company;
    const now = new Date();
    const items = [...changes].reverse().map((change) => {
      const at = new Date(Number(change.unixUs) / 1000);
      const time = make('time', { dateTime: at.toISOString() }, timeText(change.unixUs, now));
      return make('li', {}, make('span', {}, changeText(change)), time);
    });
    this.changes.replaceChildren(...items);
    element('people-unchanged').hidden = items.length > 0 || !this.parts.company.isKnown;
  }
}

function personItem({ name, detail, isMarked }: PersonLine): HTMLElement {
  const mark = isMarked ? [make('span', { className: 'badge' }, 'you')] : [];
  return make('li', {}, make('b', {}, name), ...mark, make('small', {}, detail));
}
