import type { Access } from '../../gen/kerf/v1/access_service_pb';
import type { Reporter } from '../../notifier';
import { element, setText } from '../dom';
import type { Panel } from '../side_panels';
import { scopeText, untilText } from './access_text';
import type { Session } from './session';
import type { ShareForm } from './share_form';

/** The parts of the viewer that this panel uses. */
export interface AccessParts {
  readonly session: Pick<Session, 'logOut'>;
  readonly loginDialog: { open(why: undefined): void };
  readonly panels: { toggle(id: string): void };
  readonly share: Pick<ShareForm, 'clear'>;
  readonly notices: Reporter;
}

/**
 * Shows who is logged in, with which rights and until when. Its button has no key, because the page has it only if the
 * server asks for tokens.
 */
export class AccessPanel implements Panel {
  private readonly button = document.querySelector<HTMLElement>('[data-panel=access]')!;

  constructor(private readonly parts: AccessParts) {
    const { session, loginDialog, panels, notices } = parts;
    this.button.addEventListener('click', () => panels.toggle('access'));
    element('log-out').addEventListener('click', () => void notices.attempt(() => session.logOut(), 'You are still logged in: '));
    element('log-in').addEventListener('click', () => loginDialog.open(undefined));
  }

  opened(): void {}

  closed(): void {
    this.parts.share.clear();
  }

  /** @param access  undefined: the user is logged out */
  show(access: Access | undefined): void {
    this.button.hidden = access !== undefined && !access.asksForTokens;
    element('access-out').hidden = access !== undefined;
    element('access-in').hidden = access === undefined;
    if (!access) return;
    const { tokenId, scope, sheets, expiresUnixS } = access;
    setText(element('access-token'), tokenId);
    setText(element('access-scope'), scopeText(scope));
    setText(element('access-sheets'), sheets === '*' ? 'all' : sheets);
    setText(element('access-until'), untilText(expiresUnixS));
  }
}
