// A first visit: which bytes the viewer's files take on the wire, and that the browser reads them.
import { readFileSync, readdirSync } from 'node:fs';
import { get } from 'node:http';
import { brotliDecompressSync, gunzipSync } from 'node:zlib';
import { check } from './harness.mjs';
import { ViewerPage } from './viewer_page.mjs';

// Brotli, which browsers take on this machine and over https: all scripts. gzip: those that a first visit loads.
const kMostScriptBytes = 320_000;
const kDecoders = { br: brotliDecompressSync, gzip: gunzipSync };

/** The response as it came, its body not unpacked. */
function fetchRaw(url, coding) {
  return new Promise((resolve, reject) => {
    const asked = get(url, { headers: { 'accept-encoding': coding } }, async (response) => {
      const parts = await response.toArray();
      resolve({ status: response.statusCode, headers: response.headers, body: Buffer.concat(parts) });
    });
    asked.once('error', reject);
  });
}

export function loadingSteps(steps, browser, server) {
  const { url, web } = server;

  for (const [coding, decode] of Object.entries(kDecoders)) {
    steps.step(`scripts as ${coding} are below ${kMostScriptBytes / 1000} kB and unpack to what was built`, async () => {
      const page = readFileSync(`${web}/index.html`, 'utf8');
      const isForFirstVisit = (name) => page.includes(name) || name.startsWith('watch_worker');
      const scripts = readdirSync(`${web}/assets`).filter((name) => name.endsWith('.js'));
      check(scripts.length > 1, `the viewer has ${scripts.length} scripts`);
      const bytes = { all: 0, firstVisit: 0 };
      for (const name of scripts) {
        const { status, headers, body } = await fetchRaw(`${url}/assets/${name}`, coding);
        check(status === 200, `${name}: ${status}`);
        check(headers['content-encoding'] === coding, `${name} came as ${headers['content-encoding']}`);
        check(headers.vary === 'Accept-Encoding', `${name} varies by ${headers.vary}`);
        check(Number(headers['content-length']) === body.length, `${name}: ${headers['content-length']} bytes were announced`);
        check(decode(body).equals(readFileSync(`${web}/assets/${name}`)), `${name} unpacks to something else`);
        bytes.all += body.length;
        if (isForFirstVisit(name)) bytes.firstVisit += body.length;
      }
      console.log(`  scripts as ${coding}: ${bytes.all} bytes, ${bytes.firstVisit} of them for a first visit`);
      const counted = coding === 'br' ? bytes.all : bytes.firstVisit;
      check(bytes.firstVisit > 0 && counted < kMostScriptBytes, `scripts take ${counted} bytes`);
    });
  }

  steps.step('the page loads with encoded files', async () => {
    const viewer = await ViewerPage.open(browser, url, { viewport: { width: 640, height: 400 } });
    await viewer.untilDrawn('k.connection === "live" && k.framesDrawn > 0');
    const loaded = await viewer.page.evaluate(() =>
      performance
        .getEntriesByType('resource')
        .filter(({ name }) => /\.(js|css)$/.test(name))
        .map(({ name, encodedBodySize, decodedBodySize }) => ({ name, encodedBodySize, decodedBodySize })),
    );
    check(loaded.length >= 2, `${loaded.length} scripts and styles were loaded`);
    for (const { name, encodedBodySize, decodedBodySize } of loaded) {
      check(encodedBodySize < decodedBodySize / 2, `${name}: ${encodedBodySize} of ${decodedBodySize} bytes`);
    }
    check(viewer.errors.length === 0, viewer.errors.join('; '));
  });
}
