import type { AudienceNews } from '../../stream/watch';
import type { KeyboardPointer } from '../../tools/keyboard_pointer';
import { PointerDots, kOwnDot } from '../../tools/pointer_dots';
import { Pointing } from '../../tools/pointing';
import type { Viewer } from '../../tools/tool';
import { element } from '../dom';
import type { SidePanels } from '../side_panels';
import { Arrivals } from './arrivals';
import { Company } from './company';
import { PeoplePanel } from './people_panel';
import { joinedText, personName } from './person_text';

/** The parts of the viewer that concern the others. */
export interface PeopleParts {
  readonly viewer: Viewer;
  readonly tools: { readonly keyboardPointer: Pick<KeyboardPointer, 'at'> };
  readonly imageMode: { readonly isOn: boolean };
  readonly panels: Pick<SidePanels, 'toggle'>;
}

/** The others who watch the sheet: who they are, what they did and where they point, as the stream says. */
export class People {
  readonly panel: PeoplePanel;
  readonly pointing: Pointing;

  private readonly company = new Company();
  private readonly arrivals = new Arrivals();
  private readonly dots: PointerDots;
  private readonly joined = element('people-joined');

  constructor(private readonly parts: PeopleParts) {
    const { viewer, tools, panels } = parts;
    this.dots = new PointerDots(viewer);
    const button = element('pointing');
    this.pointing = new Pointing(element('stage'), viewer, {
      onToggled: (isOn) => button.setAttribute('aria-pressed', String(isOn)),
      onPointed: (material) => this.dots.set(kOwnDot, '', material),
      cross: () => tools.keyboardPointer.at,
    });
    this.panel = new PeoplePanel({
      company: this.company,
      live: viewer.live,
      notices: viewer.notices,
      showsPictures: () => parts.imageMode.isOn,
      share: () => {
        panels.toggle('access');
        element('share-scope').focus();
      },
    });
  }

  /** True if the places of dots on the sheet are needed. */
  get arePointersShown(): boolean {
    return this.pointing.isOn || !this.dots.isEmpty;
  }

  take(news: AudienceNews): void {
    const { company, dots } = this;
    if (news.case === 'activity') {
      company.takeActivity(news.value);
    } else if (news.case === 'pointer') {
      const { viewer: number, material } = news.value;
      const viewer = company.viewer(number);
      dots.set(number, viewer ? personName(viewer) : 'someone', material);
    } else {
      company.takeAudience(news.value);
      dots.keepOnly(company.numbers);
      this.greet();
    }
  }

  /** Forgets all, when a connection begins or ends. */
  clear(): void {
    this.company.clear();
    this.arrivals.clear();
    this.dots.clear();
    this.pointing.begin();
  }

  /** Puts the dots where the sheet is now. Call it before each drawing. */
  place(): void {
    this.pointing.update();
    this.dots.update();
  }

  /** Shows who is there and what they did. Call it at each animation frame; it is cheap if nothing has changed. */
  update(): void {
    this.panel.update();
  }

  // Announces who has joined, for those who do not see the count.
  private greet(): void {
    const pages = this.company.pages(this.parts.imageMode.isOn);
    const names = new Map(pages.map((page) => [page.number, personName(page)]));
    const persons = new Set(pages.filter(({ tokenId, byLink }) => tokenId !== '' && !byLink).map(personName));
    const text = joinedText(this.arrivals.saw(names, performance.now(), persons));
    if (text !== '') this.joined.replaceChildren(text);
  }
}
