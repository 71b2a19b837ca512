import { readFileSync } from 'node:fs';
import { check, root } from './harness.mjs';

const axe = readFileSync(`${root}/web/node_modules/axe-core/axe.min.js`, 'utf8');

// The page's policy allows no script from elsewhere; what the browser's own tools run, it does not ask.
async function violations(page) {
  const session = await page.context().newCDPSession(page);
  const run = (expression) => session.send('Runtime.evaluate', { expression, awaitPromise: true, returnByValue: true });
  const { result: isThere } = await run('typeof axe === "object"');
  if (!isThere.value) await run(axe);
  const { result } = await run(`axe.run(document, { resultTypes: ['violations'] }).then(({ violations }) =>
    violations.map(({ id, nodes }) => id + ': ' + nodes.map(({ target }) => target.join(' ')).join(', ')))`);
  await session.detach();
  return result.value;
}

/** Checks the page, as it is now, for faults that keep people out. */
export async function audit(page, where) {
  const found = await violations(page);
  check(found.length === 0, `axe, ${where}: ${found.join('; ')}`);
}
