import { check, kPatienceMs, root } from './harness.mjs';
import { readPng } from './png.mjs';

// Least time between two drawings of a page.
const kFrameMs = 150;

// Made here and sent as source: the page's content security policy forbids making functions there.
function pageFunction(expression) {
  return new Function('given', `const k = window.kerf; return k && (${expression});`);
}

// Keeps `frameMs` between two drawings of a page. Drawing in software then leaves time to server, input and screenshots.
// Callbacks without a parameter draw nothing, and run with every frame.
function drawSeldom(frameMs) {
  const nextFrame = window.requestAnimationFrame.bind(window);
  let drawnMs = -Infinity;
  const waiting = [];
  window.requestAnimationFrame = function seldom(callback) {
    if (callback.length === 0) return nextFrame(callback);
    return nextFrame((nowMs) => {
      if (nowMs > drawnMs && nowMs < drawnMs + frameMs) return seldom(callback);
      const drawn = window.kerf?.framesDrawn;
      callback(nowMs);
      if (window.kerf?.framesDrawn !== drawn && window.kerf.numVertices > 0) drawnMs = nowMs;
      for (const done of waiting.splice(0)) done();
    });
  };
  // Resolves once the page has drawn whatever has changed by now.
  window.allDrawn = () => new Promise((done) => waiting.push(done));
}

/** One page with the viewer, read through window.kerf (web/src/hooks.ts) and driven as a person would. */
export class ViewerPage {
  /** Uncaught exceptions of all pages there were. */
  static exceptions = [];

  /** Errors of the page's console and uncaught exceptions. */
  errors = [];

  constructor(page) {
    this.page = page;
    page.setDefaultTimeout(kPatienceMs);
    page.on('console', (message) => message.type() === 'error' && this.errors.push(message.text()));
    page.on('pageerror', (error) => {
      this.errors.push(String(error));
      ViewerPage.exceptions.push(error.stack ?? String(error));
    });
  }

  /**
   * @param options  of the page; frameMs: least time between two drawings, 0 for as many as there can be; isAdaptive: the
   *                 page chooses its resolution, which otherwise is full; isFirstVisit: with the hint of a first visit
   * @param prepare  called with the page before it loads anything
   */
  static async open(browser, url, given, prepare = async () => {}) {
    const { frameMs = kFrameMs, isAdaptive = false, isFirstVisit = false, ...options } = given;
    const viewer = new ViewerPage(await browser.newPage(options));
    await viewer.page.addInitScript(drawSeldom, frameMs);
    if (!isFirstVisit) await viewer.page.addInitScript(() => localStorage.setItem('kerf-hint', 'seen'));
    await prepare(viewer.page);
    const address = new URL(url);
    if (!isAdaptive) address.searchParams.set('resolution', 'full');
    await viewer.page.goto(address.href);
    return viewer;
  }

  /** Pictures of whatever is open, as NAME-1.png and so on; gives their paths. */
  static async screenshotAll(browser, name) {
    const pages = browser.contexts().flatMap((context) => context.pages());
    const paths = pages.map((_, i) => `${root}build/e2e/${name}-${i + 1}.png`);
    const taken = await Promise.allSettled(pages.map((page, i) => page.screenshot({ path: paths[i] })));
    return paths.map((path, i) => taken[i].reason ? `none: ${taken[i].reason.message}` : path);
  }

  /** Waits until `condition`, an expression of window.kerf as k and of `given`, is true of it. */
  async until(condition, given = {}) {
    await this.page.waitForFunction(pageFunction(condition), given, { timeout: kPatienceMs }).catch((error) => {
      throw new Error(
        `not within ${kPatienceMs / 1000} s: ${condition} (given ${JSON.stringify(given)}): ${error.message}`,
      );
    });
  }

  /** The same, and until what is there then is drawn: the first frame of a page is drawn before there is a sheet. */
  async untilDrawn(condition, given = {}) {
    await this.until(condition, given);
    await this.allDrawn();
  }

  read(expression) {
    return this.page.evaluate(pageFunction(expression), {});
  }

  /** Position of a material point on the page. */
  async at(x, y) {
    const point = await this.page.evaluate(([px, py]) => window.kerf.toClient(px, py), [x, y]);
    check(point, `material point (${x}, ${y}) is not in view`);
    return point;
  }

  async tap(x, y) {
    const point = await this.at(x, y);
    await this.page.mouse.click(point.x, point.y);
  }

  /** Presses at one point of the page, moves to another in steps, and stays down. */
  async drag(from, to) {
    await this.page.mouse.move(from.x, from.y);
    await this.page.mouse.down();
    await this.page.mouse.move(to.x, to.y, { steps: 8 });
  }

  /** The same with one finger, which is lifted at the end. */
  async touchDrag(from, to) {
    const session = await this.page.context().newCDPSession(this.page);
    const touch = (type, ...touchPoints) => session.send('Input.dispatchTouchEvent', { type, touchPoints });
    const kSteps = 8;
    await touch('touchStart', from);
    for (let i = 1; i <= kSteps; ++i) {
      const part = i / kSteps;
      await touch('touchMove', { x: from.x + part * (to.x - from.x), y: from.y + part * (to.y - from.y) });
    }
    await touch('touchEnd');
    await session.detach();
  }

  /** Sends the data of the page at this many bytes a second, until it is called with -1. */
  async throttleUploads(bytesPerS) {
    this.network ??= await this.page.context().newCDPSession(this.page);
    await this.network.send('Network.enable');
    const conditions = { offline: false, latency: 0, downloadThroughput: -1, uploadThroughput: bytesPerS };
    await this.network.send('Network.emulateNetworkConditions', conditions);
  }

  /** Drops a file on the sheet. */
  async drop(name, bytes) {
    const transfer = await this.page.evaluateHandle(
      ([base64, fileName]) => {
        const content = Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0));
        const files = new DataTransfer();
        files.items.add(new File([content], fileName));
        return files;
      },
      [bytes.toString('base64'), name],
    );
    await this.page.dispatchEvent('#canvas', 'drop', { dataTransfer: transfer });
  }

  async choose(tool) {
    await this.page.click(`#tools [data-tool=${tool}]`);
    await this.until('k.tool === given.tool', { tool });
  }

  /** Opens another of the server's sheets with the picker. */
  async pick(sheet) {
    await this.page.focus('#sheet-picker');
    await this.page.selectOption('#sheet-picker', `sheets/${sheet}`);
    // Letters typed into a picker choose in it.
    await this.page.focus('#canvas');
  }

  /**
   * Gives the page's requests of an address to `handler`, as page.route() does. The page's next request is among them, which
   * page.route() alone does not ensure: Chromium answers before the page's own process knows.
   */
  async route(url, handler, options) {
    if (!this.isIntercepted) {
      const isProbe = ({ search }) => search === '?is-routed';
      await this.page.route(isProbe, (route) => route.fulfill({ body: 'yes' }));
      await this.page.evaluate(async () => {
        let text;
        do text = await (await fetch('/?is-routed')).text();
        while (text !== 'yes');
      });
      this.isIntercepted = true; // for as long as the probe has its route
    }
    await this.page.route(url, handler, options);
  }

  /** Answers to a method's calls wait: `asked` is over when there is one, release() lets all of them come. */
  async hold(method) {
    const url = `**/kerf.v1.${method}`;
    let setAsked;
    let setReleased;
    const asked = new Promise((resolve, reject) => {
      setAsked = resolve;
      setTimeout(() => reject(new Error(`the page did not call ${method}`)), kPatienceMs).unref();
    });
    asked.catch(() => {}); // reported where it is awaited
    const released = new Promise((resolve) => (setReleased = resolve));
    await this.route(url, async (route) => {
      setAsked();
      await released;
      await route.continue();
    });
    const release = async () => {
      const answered = this.page.waitForResponse(url);
      setReleased();
      await (await answered).finished();
      await this.page.unroute(url);
    };
    return { asked, release };
  }

  /** Holds the answer to a method's next call: `answered` is over once the server has answered, release() lets it come. */
  async holdAnswer(method) {
    const url = `**/kerf.v1.${method}`;
    let setAnswered;
    let setReleased;
    const answered = new Promise((resolve) => (setAnswered = resolve));
    const released = new Promise((resolve) => (setReleased = resolve));
    let fulfilled;
    const hold = async (route) => {
      const response = await route.fetch();
      setAnswered();
      await released;
      await route.fulfill({ response });
    };
    await this.route(url, (route) => (fulfilled = hold(route)), { times: 1 });
    const release = () => {
      setReleased();
      return fulfilled;
    };
    return { answered, release };
  }

  /** Tells the page that it is hidden, so that it draws nothing, or that it is visible again. */
  setHidden(isHidden) {
    return this.page.evaluate((value) => {
      const waiting = [];
      window.requestSeenFrame ??= window.requestAnimationFrame;
      window.showFrames?.();
      window.requestAnimationFrame = value ? (callback) => waiting.push(callback) : window.requestSeenFrame;
      window.showFrames = () => waiting.forEach((callback) => window.requestSeenFrame(callback));
      Object.defineProperty(document, 'hidden', { configurable: true, value });
      document.dispatchEvent(new Event('visibilitychange'));
    }, isHidden);
  }

  /** Waits until an element's text is this one. */
  async shows(selector, text) {
    const isShown = ([query, wanted]) => document.querySelector(query).textContent === wanted;
    await this.page.waitForFunction(isShown, [selector, text], { timeout: kPatienceMs }).catch(async (error) => {
      const shown = await this.page.textContent(selector).catch(() => 'nothing');
      throw new Error(`${selector} shows '${shown}', not '${text}': ${error.message}`);
    });
  }

  /** A handle of an array of all texts that an element has from now on. */
  textsOf(selector) {
    return this.page.evaluateHandle((query) => {
      const element = document.querySelector(query);
      const texts = [element.textContent];
      const options = { childList: true, characterData: true, subtree: true };
      new MutationObserver(() => texts.push(element.textContent)).observe(element, options);
      return texts;
    }, selector);
  }

  /** Colours of a screenshot of the page at points of it, CSS pixels: an array of [red, green, blue], 0..255. */
  async colours(points, name) {
    const png = await this.picture(name);
    const scale = png.readUInt32BE(16) / this.page.viewportSize().width;
    const pixels = points.map(({ x, y }) => ({ x: scale * x, y: scale * y }));
    return this.coloursOf(png, pixels);
  }

  /** Colours of a PNG at points of it, pixels. */
  coloursOf(png, points) {
    const { at } = readPng(png);
    return points.map(({ x, y }) => at(Math.floor(x), Math.floor(y)));
  }

  /** Counts the pixels of the page that have this colour, within rounding. */
  async numPixels(colour, name) {
    const { width, height, at } = readPng(await this.picture(name));
    let count = 0;
    for (let i = 0; i < width * height; ++i) {
      const pixel = at(i % width, Math.floor(i / width));
      if (colour.every((value, channel) => Math.abs(pixel[channel] - value) <= 3)) count += 1;
    }
    return count;
  }

  notice(pattern) {
    return this.page.locator('.notice', { hasText: pattern }).first().waitFor();
  }

  /** A picture of what is there now: two more frames are drawn first if the sheet moves. */
  async screenshot(name) {
    if (await this.read('k.connection === "live" && !k.isPaused')) {
      await this.until('k.framesDrawn >= given.drawn', { drawn: (await this.read('k.framesDrawn')) + 2 });
    }
    await this.picture(name);
  }

  /** Waits until the page has drawn whatever has changed by now. */
  allDrawn() {
    return this.page.evaluate(() => window.allDrawn());
  }

  /** The page as a PNG, with all that has changed by now; also kept as a file. */
  async picture(name) {
    await this.allDrawn();
    return this.page.screenshot({ path: `${root}build/e2e/${name}.png` });
  }
}
