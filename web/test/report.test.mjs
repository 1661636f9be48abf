// The player of landings in reports, in a real browser.
import assert from 'node:assert/strict';
import { mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { browser, PATIENCE_MS, pictures, touchdown, withCommand } from './browser.mjs';

let chromium;
const folder = mkdtempSync(join(tmpdir(), 'report-'));
before(async () => {
  mkdirSync(pictures, { recursive: true });
  chromium = await browser();
});
after(async () => {
  await chromium?.close();
  rmSync(folder, { recursive: true });
});

/** The file of a report, with everything that its page asks for or complains of. */
async function open(path, { reduced = false } = {}) {
  const page = await chromium.newPage();
  const seen = { requests: [], errors: [] };
  await page.setViewport({ width: 1280, height: 900 });
  page.setDefaultTimeout(PATIENCE_MS);
  await page.emulateMediaFeatures([{ name: 'prefers-reduced-motion', value: reduced ? 'reduce' : 'no-preference' }]);
  page.on('request', (request) => seen.requests.push(request.url()));
  page.on('pageerror', (error) => seen.errors.push(String(error)));
  page.on('console', (message) => message.type() === 'error' && seen.errors.push(message.text()));
  await page.goto(`file://${path}`);
  return { page, seen };
}

test('regress_a_landing_in_a_report_plays_to_its_end_and_again', withCommand, async () => {
  writeFileSync(join(folder, 'sweep.toml'), 'seed = 5\ntrials = 2\n[scenario.deck]\nkind = "sea"\n');
  const out = join(folder, 'campaign');
  touchdown('--quiet', 'campaign', join(folder, 'sweep.toml'), '--out', out);
  const { page, seen } = await open(join(out, 'report.html'), { reduced: true });
  await page.$eval('figure.scene', (figure) => figure.scrollIntoView({ block: 'center' }));
  await page.waitForSelector('figure.scene.drawn canvas');
  const shown = () => page.$eval('figure.scene output', (output) => output.textContent);
  const begin = await shown();
  const legend = () => page.$$eval('figure.scene .legend tbody tr', (rows) => rows.map((row) => [...row.cells].map((cell) => cell.textContent)));
  const first = await legend();
  assert.match(first.join(), /^[^,]+,-?\d+\.\d %(,\s?\d+\.\d){4}$/);
  await page.screenshot({ path: join(pictures, 'report-begin.png') });
  // The bar goes to the end: the vehicle stands.
  await page.$eval('figure.scene input', (bar) => {
    bar.value = bar.max;
    bar.dispatchEvent(new Event('input'));
  });
  const end = await shown();
  assert.notEqual(begin, end);
  assert.notDeepEqual(await legend(), first, 'the legend follows the time');
  assert.match(end, /, [a-z ]+$/, end);
  await page.screenshot({ path: join(pictures, 'report-end.png') });
  // From the end, playing begins again; the time moves and can be stopped.
  await page.click('figure.scene button');
  await page.waitForFunction((of) => document.querySelector('figure.scene output').textContent !== of, {}, end);
  await page.click('figure.scene button');
  const stopped = await shown();
  assert.equal(await page.$eval('figure.scene button', (button) => button.textContent), 'Play');
  assert.ok(parseFloat(stopped) < parseFloat(end), `${stopped} before ${end}`);
  assert.deepEqual(seen.errors, []);
  const outside = seen.requests.filter((url) => !/^(blob|data):/.test(url));
  assert.equal(outside.length, 1, `the page alone, found ${outside}`);
  const size = readFileSync(join(out, 'report.html')).length;
  console.log(`# report.html: ${Math.round(size / 1000)} kB`);
  await page.close();
});

test('analytic_a_landing_plays_when_it_is_looked_at_unless_motion_is_reduced', withCommand, async () => {
  const report = join(folder, 'campaign', 'report.html');
  for (const reduced of [false, true]) {
    const { page } = await open(report, { reduced });
    await page.$eval('figure.scene', (figure) => figure.scrollIntoView({ block: 'center' }));
    await page.waitForSelector('figure.scene.drawn canvas');
    const label = () => page.$eval('figure.scene button', (button) => button.textContent);
    if (!reduced) {
      await page.waitForFunction(() => document.querySelector('figure.scene button').textContent === 'Pause');
    }
    assert.equal(await label(), reduced ? 'Play' : 'Pause');
    await page.close();
  }
});
