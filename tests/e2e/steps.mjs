// Groups of named steps. All are declared first, so that their number is known, and then run in order.

// The longest step has several waits, each with a limit of its own.
const kStepMs = 300_000;

/** Returns the value of `promise`; throws if that takes longer than `limitMs`. */
export async function within(limitMs, promise, what) {
  let timer;
  const late = new Promise((_, reject) => {
    timer = setTimeout(() => reject(new Error(`not within ${limitMs / 1000} s: ${what}`)), limitMs);
  });
  return Promise.race([promise, late]).finally(() => clearTimeout(timer));
}

function seconds(startedMs) {
  return `${((performance.now() - startedMs) / 1000).toFixed(1)} s`;
}

/** The steps of one group in their order; each builds on those before it. */
export class Group {
  steps = [];

  constructor(name) {
    this.name = name;
  }

  /** Declares a step. */
  step(name, run) {
    this.steps.push({ name, run });
  }

  /** Says if the group or one of its steps has this text in its name, capitals or not. */
  isAbout(text) {
    const wanted = text.toLowerCase();
    return [this.name, ...this.steps.map(({ name }) => name)].some((name) => name.toLowerCase().includes(wanted));
  }
}

/** Runs groups and counts steps; after a failure the rest of its group is not run and counts as failed. */
export class Runner {
  passed = 0;
  failed = 0;

  /**
   * @param prepare    called with a group before its first step
   * @param afterStep  called after each step; what it throws fails the step
   * @param onFailure  called with group and name of a step that failed; returns lines that help whoever reads of it
   * @param afterGroup called with a group and whether all of its steps have passed
   */
  constructor({ prepare, afterStep, onFailure, afterGroup }) {
    Object.assign(this, { prepare, afterStep, onFailure, afterGroup });
  }

  async run(groups) {
    this.total = groups.reduce((sum, { steps }) => sum + steps.length, 0);
    for (const group of groups) await this.runGroup(group);
    console.log(`${this.passed} passed, ${this.failed} failed`);
  }

  async runGroup(group) {
    let hasFailed = false;
    for (const [i, { name, run }] of group.steps.entries()) {
      if (hasFailed) {
        this.report('not run', name);
        continue;
      }
      const startedMs = performance.now();
      try {
        if (i === 0) await this.prepare(group);
        await within(kStepMs, run(), 'this step ends');
        await this.afterStep();
        this.report('passed', name, startedMs);
      } catch (error) {
        hasFailed = true;
        this.report('FAILED', name, startedMs);
        console.log([error.stack ?? String(error), ...(await this.onFailure(group, name))].join('\n'));
      }
    }
    await this.afterGroup(group, !hasFailed);
  }

  report(outcome, name, startedMs) {
    if (outcome === 'passed') this.passed += 1;
    else this.failed += 1;
    const place = `[${this.passed + this.failed}/${this.total}]`;
    const time = startedMs === undefined ? '' : ` (${seconds(startedMs)})`;
    console.log(`${place} ${outcome.padEnd(8)} ${name}${time}`);
  }
}
