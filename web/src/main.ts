import { App } from './app';
import { element } from './ui/dom';

async function start(): Promise<void> {
  await new App().start();
}

start().catch((error: Error) => {
  const line = element('connection-detail');
  line.hidden = false;
  line.textContent = `The viewer cannot start: ${error.message}`;
});
