import type { Notifier } from '../../notifier';

/**
 * Copies the link in a field, or marks it if the browser does not let the page copy.
 * @param copied  notice after a copy
 */
export async function copyField(field: HTMLInputElement, copied: string, notifier: Notifier): Promise<void> {
  try {
    await navigator.clipboard.writeText(field.value);
    notifier.notify('success', copied);
  } catch {
    // Browsers have no clipboard for pages without TLS. A click moves the focus to the sheet first (ui/keys.ts).
    setTimeout(() => {
      field.focus();
      field.select();
    });
    notifier.notify('info', 'The browser does not let the page copy: copy the marked link by hand');
  }
}
