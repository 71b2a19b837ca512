import { element, setText } from './dom';

/** Asks before something is deleted for good; true if the user agrees. */
export function confirmed(question: string, what: string): Promise<boolean> {
  const dialog = element<HTMLDialogElement>('confirmation');
  setText(element('confirmation-question'), question);
  setText(element('confirmation-yes'), what);
  // Clears the last answer, which a dialog keeps if it is dismissed with Escape.
  dialog.returnValue = '';
  dialog.showModal();
  return new Promise((resolve) => {
    dialog.addEventListener('close', () => resolve(dialog.returnValue === 'yes'), { once: true });
  });
}
