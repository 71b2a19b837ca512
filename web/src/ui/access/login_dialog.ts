import type { ApiError } from '../../api';
import { element, setText } from '../dom';
import { errorText } from '../error_text';

// The server's own texts for these reasons are about a first visit, and about cookies.
const kEnded = 'You are logged out: the login has ended, or was ended in another tab';

function refusalText(error: ApiError): string {
  if (error.reason === 'TOKEN_MISSING' || error.reason === 'LOGIN_UNKNOWN') return kEnded;
  // Other remedies are about calls.
  return error.code === 'UNAVAILABLE' ? errorText(error) : error.message;
}

/** Asks for a token. It can be closed without one: see Session.putOff(). */
export class LoginDialog {
  private readonly dialog = element<HTMLDialogElement>('login');
  private readonly token = element<HTMLInputElement>('login-token');
  private readonly error = element('login-error');
  private readonly button = element<HTMLButtonElement>('login-enter');

  /**
   * @param logIn   throws an ApiError if the token is refused
   * @param closed  called when the dialog has been closed, also after a login
   */
  constructor(
    private readonly logIn: (token: string) => Promise<void>,
    closed: () => void,
  ) {
    this.dialog.querySelector('form')!.addEventListener('submit', (event) => {
      event.preventDefault();
      void this.submit();
    });
    this.dialog.querySelector('[data-close]')!.addEventListener('click', () => this.close());
    this.dialog.addEventListener('close', () => {
      this.token.value = '';
      closed();
    });
    this.token.addEventListener('input', () => this.showError(''));
  }

  /** @param why  the refusal; undefined if the user has just come */
  open(why: ApiError | undefined): void {
    this.showError(why ? refusalText(why) : '');
    if (!this.dialog.open) this.dialog.showModal();
  }

  close(): void {
    this.dialog.close();
  }

  private async submit(): Promise<void> {
    const token = this.token.value.trim();
    if (token === '') return this.refuse('Give a token');
    this.button.disabled = true;
    try {
      await this.logIn(token);
    } catch (error) {
      this.refuse(refusalText(error as ApiError));
    } finally {
      this.button.disabled = false;
    }
  }

  private refuse(text: string): void {
    this.showError(text);
    this.token.setAttribute('aria-invalid', 'true');
    this.token.focus();
    this.token.select();
  }

  private showError(text: string): void {
    setText(this.error, text);
    this.error.hidden = text === '';
    this.token.removeAttribute('aria-invalid');
  }
}
