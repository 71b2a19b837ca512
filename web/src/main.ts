import { App } from './app';
import { takeCode } from './ui/access/link_code';
import { element } from './ui/dom';

async function start(): Promise<void> {
  // Takes the code before anything else, because App sends requests.
  const code = takeCode();
  await new App().start(code);
}

start().catch((error: Error) => {
  const line = element('connection-detail');
  line.hidden = false;
  line.textContent = `The viewer cannot start: ${error.message}`;
});
