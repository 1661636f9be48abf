// What the tests share: a browser, the page, and the command line.
import { execFileSync } from 'node:child_process';
import { existsSync, mkdtempSync, readFileSync, readdirSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';
import puppeteer from 'puppeteer-core';
import { serve } from '../serve.mjs';

const here = dirname(fileURLToPath(import.meta.url));
export const root = dirname(dirname(here));
export const dist = join(root, 'web', 'dist');
/** The folder of measured logs: by default beside the project. Tests that need it say when it is not there. */
const logs = process.env.TOUCHDOWN_DATA ?? join(root, '..', 'shared', 'data');
export const data = existsSync(logs) ? logs : undefined;
export const withData = { skip: !data && `no measured logs at ${logs} (TOUCHDOWN_DATA names another folder)` };
/** Screenshots stay there for a look. */
export const pictures = join(root, 'target', 'web');
const command = process.env.TOUCHDOWN ?? join(process.env.CARGO_TARGET_DIR ?? join(root, 'target'), 'debug', 'touchdown');
const hasCommand = existsSync(command);
export const withCommand = { skip: !hasCommand && `the command is not built (${command})` };
export const fixtures = join(root, 'crates', 'log', 'tests', 'reference', 'fixtures');

/** Calculations take seconds, on a busy machine tens of them. */
export const PATIENCE_MS = 180_000;

export async function browser() {
  return puppeteer.launch({
    executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium',
    args: [
      '--no-sandbox',
      '--use-angle=swiftshader',
      '--enable-unsafe-swiftshader',
      '--disable-dev-shm-usage',
    ],
    protocolTimeout: PATIENCE_MS,
  });
}

/** Memory of the browser's processes that hold pages and their workers, in MB. */
export function memory(chromium) {
  const rows = execFileSync('ps', ['-eo', 'pid=,ppid=,rss=,args=']).toString().trim().split('\n');
  const processes = rows.map((row) => row.trim().split(/\s+/, 3).map(Number).concat(row));
  const own = new Set([chromium.process().pid]);
  for (let before = 0; before < own.size; ) {
    before = own.size;
    for (const [pid, parent] of processes) if (own.has(parent)) own.add(pid);
  }
  const pages = processes.filter(([pid, , , row]) => own.has(pid) && row.includes('--type=renderer'));
  return Math.max(0, ...pages.map(([, , kilobytes]) => kilobytes / 1000));
}

/** The lab in a tab, with every request and every error that it causes. */
export class Page {
  requests = [];
  errors = [];

  static async open(of, { hash = '', file = false, width = 1280, height = 900 } = {}) {
    const made = new Page();
    made.server = file ? undefined : await serve(0);
    // A test that fails leaves it open, which must not keep the tests from ending.
    made.server?.unref();
    made.page = await of.newPage();
    // With the size Puppeteer sets an orientation, which Firefox ESR 140 does not know; the size is set all the same.
    await made.page.setViewport({ width, height }).catch((error) => {
      if (!error.message.includes('setScreenOrientationOverride')) throw error;
    });
    made.page.setDefaultTimeout(PATIENCE_MS);
    made.page.on('request', (request) => made.requests.push(request.url()));
    made.page.on('pageerror', (error) => made.errors.push(String(error)));
    made.page.on('console', (message) => {
      if (message.type() === 'error') made.errors.push(message.text());
    });
    made.url = file
      ? `file://${join(dist, 'touchdown-lab.html')}${hash}`
      : `http://127.0.0.1:${made.server.address().port}/${hash}`;
    await made.page.goto(made.url);
    await made.page.waitForSelector('html[data-ready]');
    return made;
  }

  async close() {
    await this.page.close();
    this.server?.close();
  }

  /** Requests but those of the page's own texts. */
  connections() {
    return this.requests.filter((url) => !/^(blob|data):/.test(url));
  }

  /** Drops files on the zone, as a person does. */
  async drop(...files) {
    const contents = files.map((file) => [file.split('/').at(-1), readFileSync(file).toString('base64')]);
    await this.page.evaluate((all) => {
      const transfer = new DataTransfer();
      for (const [name, text] of all) {
        const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
        transfer.items.add(new File([bytes], name));
      }
      document.querySelector('.drop').dispatchEvent(new DragEvent('drop', { dataTransfer: transfer, bubbles: true }));
    }, contents);
  }

  /** Sets up step 2 for the ground effect of the example's flights. */
  async groundEffectOfFlights() {
    await this.tab('model');
    await this.page.select('#task', 'identify_ground_effect');
    await this.page.type('#mass', '1.37');
    await this.page.type('#radius', '0.12');
  }

  /** Puts a map into the editor. */
  async map(text) {
    await this.page.$eval(
      '#map',
      (area, to) => {
        area.closest('details').open = true;
        area.value = to;
        area.dispatchEvent(new Event('input'));
      },
      text,
    );
  }

  tab(name) {
    return this.page.click(`#tab-${name}`);
  }

  /** Waits until an element's text passes a test; the text. Firefox ESR 140 holds `waitForFunction` to the page's policy, which stops it. */
  async text(selector, test) {
    const until = Date.now() + PATIENCE_MS;
    for (;;) {
      const text = await this.page.evaluate((of) => document.querySelector(of)?.innerText ?? '', selector);
      if (test.test(text)) return text;
      if (Date.now() > until) throw new Error(`${selector}: expected ${test}; found ${text}`);
      await new Promise((resolve) => setTimeout(resolve, 10));
    }
  }

  /** A table by its caption: rows of cells, with all digits of numbers. */
  table(caption) {
    return this.page.evaluate((of) => {
      const found = [...document.querySelectorAll('table')].find((t) => t.caption?.textContent.startsWith(of));
      if (!found) return null;
      const cell = (td) => td.querySelector('span[title]')?.title || td.textContent;
      return [...found.tBodies[0].rows].map((row) => [...row.cells].map(cell));
    }, caption);
  }

  async picture(name) {
    await this.page.screenshot({ path: join(pictures, `${name}.png`), fullPage: true });
  }

  /** The one file that a press on a button saves. */
  async saved(selector) {
    const [file] = await this.allSaved(selector, 1);
    return file;
  }

  /** The files that a press on a button saves, by their names. */
  async allSaved(selector, count) {
    const folder = mkdtempSync(join(tmpdir(), 'lab-'));
    const client = await this.page.createCDPSession();
    await client.send('Browser.setDownloadBehavior', {
      behavior: 'allow',
      downloadPath: folder,
      eventsEnabled: true,
    });
    let left = count;
    const done = new Promise((resolve) => {
      client.on('Browser.downloadProgress', (event) => event.state === 'completed' && --left === 0 && resolve());
    });
    await this.page.click(selector);
    await done;
    const files = readdirSync(folder).sort().map((name) => ({ name, content: readFileSync(join(folder, name)) }));
    rmSync(folder, { recursive: true });
    await client.detach();
    return files;
  }
}

/** Runs `touchdown`. */
export function touchdown(...args) {
  return execFileSync(command, args, { cwd: root, encoding: 'utf8', stdio: ['ignore', 'pipe', 'pipe'] });
}

/** Greatest relative difference of two lists of numbers. */
export function difference(a, b) {
  if (a.length !== b.length) throw new Error(`expected ${b.length} numbers, found ${a.length}`);
  return a.reduce((most, x, k) => {
    if (!Number.isFinite(x) || !Number.isFinite(b[k])) throw new Error(`not a number: ${x}, ${b[k]}`);
    return Math.max(most, Math.abs(x - b[k]) / Math.max(Math.abs(x), Math.abs(b[k]), 1e-12));
  }, 0);
}
