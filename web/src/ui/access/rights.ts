import { Scope } from '../../gen/kerf/v1/access_service_pb';
import type { Access } from '../../gen/kerf/v1/access_service_pb';
import type { Notifier } from '../../notifier';

// Rights that controls need, by their name in the page.
const kNamed: readonly [name: string, scope: Scope, lack: string][] = [
  ['cut', Scope.CUT, 'You may look only: changes need a token with more rights'],
  ['admin', Scope.ADMIN, 'You may not make or delete sheets: that needs a token with more rights'],
];

/**
 * The user's rights. Controls with data-needs=NAME are hidden without the right of this name, and fieldsets disabled;
 * a text with data-lacking=NAME is shown instead. A page of a server without tokens has all rights.
 */
export class Rights {
  private scope = Scope.ADMIN;

  constructor(private readonly notifier: Notifier) {}

  /** @param access  undefined: the user is logged out, and may do nothing */
  set(access: Access | undefined): void {
    if (!access) this.scope = Scope.UNSPECIFIED;
    else this.scope = access.asksForTokens ? access.scope : Scope.ADMIN;
    const lacks = kNamed.filter(([, scope]) => !this.may(scope)).map(([name]) => name);
    document.documentElement.dataset.lacks = lacks.join(' ');
    for (const group of document.querySelectorAll<HTMLFieldSetElement>('fieldset[data-needs]')) {
      group.disabled = lacks.includes(group.dataset.needs!);
    }
  }

  may(scope: Scope): boolean {
    return this.scope >= scope;
  }

  /** True if the user may do what needs this right; else says why not. */
  allows(scope: Scope): boolean {
    if (this.may(scope)) return true;
    const lack = kNamed.find(([, named]) => named === scope)?.[2] ?? '';
    this.notifier.notify('info', this.scope === Scope.UNSPECIFIED ? 'Log in first, under Access' : lack);
    return false;
  }
}
