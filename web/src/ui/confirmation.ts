import { element, setText } from './dom';

/** Asks before something is gone for good; true if it may go. */
export function confirmed(question: string, what: string): Promise<boolean> {
  const dialog = element<HTMLDialogElement>('confirmation');
  setText(element('confirmation-question'), question);
  setText(element('confirmation-yes'), what);
  // A dialog that is dismissed with Escape keeps the answer before.
  dialog.returnValue = '';
  dialog.showModal();
  return new Promise((resolve) => {
    dialog.addEventListener('close', () => resolve(dialog.returnValue === 'yes'), { once: true });
  });
}
