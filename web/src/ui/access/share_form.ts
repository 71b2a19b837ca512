import { call } from '../../api';
import { AccessService } from '../../gen/kerf/v1/access_service_pb';
import type { Notifier } from '../../notifier';
import type { OpenSheet } from '../../sheet/open_sheet';
import { sheetId } from '../../sheets';
import { element, setText } from '../dom';
import { errorText } from '../error_text';
import { scopeText, untilText } from './access_text';
import { copyField } from './copy_field';

/** Makes links to the open sheet, with which others log in. */
export class ShareForm {
  private readonly scope = element<HTMLSelectElement>('share-scope');
  private readonly lifetime = element<HTMLSelectElement>('share-lifetime');
  private readonly error = element('share-error');
  private readonly made = element('share-made');
  private readonly link = element<HTMLInputElement>('share-link');
  private readonly copyButton = element<HTMLButtonElement>('share-copy');

  constructor(
    private readonly live: Pick<OpenSheet, 'sheetName'>,
    notifier: Notifier,
    private readonly send: typeof call = call,
  ) {
    element('share-form').addEventListener('submit', (event) => {
      event.preventDefault();
      void this.make();
    });
    this.copyButton.addEventListener('click', () => void copyField(this.link, 'The link is copied', notifier));
  }

  /** Forgets the last link. */
  clear(): void {
    this.made.hidden = true;
    this.link.value = '';
    this.showError('');
  }

  async make(): Promise<void> {
    this.clear();
    const id = sheetId(this.live.sheetName);
    if (id === '') return this.showError('Open a sheet first');
    const scope = Number(this.scope.value);
    const request = { scope, sheetId: id, lifetimeS: Number(this.lifetime.value) };
    try {
      const { path, expiresUnixS } = await this.send(AccessService.method.createLink, request);
      this.link.value = `${location.origin}${path}`;
      setText(element('share-what'), `Link to ${id}: ${scopeText(scope)}, until ${untilText(expiresUnixS)}`);
      this.made.hidden = false;
      // Also scrolls the link into view, on a phone.
      this.copyButton.focus();
    } catch (error) {
      this.showError(errorText(error as Error));
    }
  }

  private showError(text: string): void {
    setText(this.error, text);
    this.error.hidden = text === '';
  }
}
