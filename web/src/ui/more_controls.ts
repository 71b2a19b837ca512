import { element } from './dom';

/** Shows a second row of controls where the window has no room for all in one: those of looks, theme and help. */
export function bindMoreControls(): void {
  const more = element('controls-more');
  more.addEventListener('click', () => {
    more.setAttribute('aria-expanded', String(more.getAttribute('aria-expanded') !== 'true'));
  });
}
