/** Marks an element with data-tabbed while it has the focus from the Tab key, not from a click or a script. */
export function markTabbedFocus(element: HTMLElement): void {
  let isTab = false;
  addEventListener('keydown', ({ key }) => void (isTab = key === 'Tab'), true);
  addEventListener('keyup', () => void (isTab = false), true);
  element.addEventListener('focus', () => void (isTab && element.setAttribute('data-tabbed', '')));
  element.addEventListener('blur', () => element.removeAttribute('data-tabbed'));
}
