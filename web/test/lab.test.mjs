import assert from 'node:assert/strict';
import { mkdirSync, mkdtempSync, readFileSync, readdirSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { browser, data, difference, hasCommand, Page, pictures, root, touchdown } from './browser.mjs';

const corpus = process.env.TOUCHDOWN_CORPUS;

let chromium;
before(async () => {
  mkdirSync(pictures, { recursive: true });
  chromium = await browser();
});
after(() => chromium?.close());

const withData = { skip: !(data && hasCommand) && 'TOUCHDOWN_DATA or the command `touchdown` is not there' };
const withCommand = { skip: !hasCommand && 'the command `touchdown` is not built' };

/** Figures differ from the command's where the C library and the browser round exp, sin and log differently: in the
 * fourteenth digit, which a fit may amplify a thousandfold. */
const SAME = 1e-9;

/** All numbers of a text, in their order. */
const numbersOf = (text) => [...text.matchAll(/-?\d+(?:\.\d+)?(?:e[-+]?\d+)?/g)].map(([n]) => Number(n));

/** The messages of an MCAP file whose messages are JSON and whose chunks are not compressed. */
function messages(file, from = 8, end = file.length - 8) {
  const all = [];
  for (let at = from; at < end; ) {
    const [kind, length] = [file[at], Number(file.readBigUInt64LE(at + 1))];
    const body = at + 9;
    if (kind === 5) all.push(JSON.parse(file.subarray(body + 22, body + length).toString()));
    if (kind === 6) {
      const name = file.readUInt32LE(body + 28);
      assert.equal(name, 0, 'a chunk that is not compressed');
      all.push(...messages(file, body + 40, body + length));
    }
    at = body + length;
  }
  return all;
}

/** Two recordings of a landing hold the same messages; numbers differ by at most SAME of their size, or of 1. */
function sameTrace(ours, theirs) {
  const numbers = (value) =>
    typeof value === 'number' ? [value] : value && typeof value === 'object' ? Object.values(value).flatMap(numbers) : [];
  const [found, wanted] = [messages(ours), messages(theirs)];
  assert.equal(found.length, wanted.length);
  let worst = 0;
  let count = 0;
  found.forEach((message, k) => {
    const [a, b] = [numbers(message), numbers(wanted[k])];
    assert.equal(a.length, b.length);
    count += a.length;
    a.forEach((x, i) => (worst = Math.max(worst, Math.abs(x - b[i]) / Math.max(1, Math.abs(b[i])))));
  });
  console.log(`# greatest difference of ${count} numbers in ${found.length} messages of a landing: ${worst}`);
  assert.ok(count > 10_000 && worst <= SAME, `${worst}`);
}

/** What is wrong with the places of what a person presses, types into and watches: outside of the page, on top of one another, or cut off. */
function misplaced() {
  const shown = [...document.querySelectorAll('button, select, textarea, summary, canvas, input:not(.hidden-input)')]
    .map((element) => ({ element, box: element.getBoundingClientRect() }))
    .filter(({ element, box }) => box.width > 0 && element.checkVisibility());
  const name = ({ element }) => element.id || element.textContent.slice(0, 20) || element.className || element.tagName;
  const found = [];
  for (const one of shown) {
    if (one.box.left < 0 || one.box.right > document.documentElement.clientWidth + 0.5) found.push(`${name(one)} leaves the page`);
    if (one.element.tagName === 'BUTTON' && one.element.scrollWidth > one.element.clientWidth + 1) found.push(`${name(one)} is cut off`);
    for (const other of shown) {
      if (other === one) break;
      const wide = Math.min(one.box.right, other.box.right) - Math.max(one.box.left, other.box.left);
      const high = Math.min(one.box.bottom, other.box.bottom) - Math.max(one.box.top, other.box.top);
      if (wide > 1 && high > 1) found.push(`${name(one)} and ${name(other)} overlap`);
    }
  }
  return found;
}

/** Two reports show the same words, tables and curves; only the paths in their commands differ. */
function sameReport(ours, theirs) {
  const shown = (html) => html.slice(html.indexOf('<body'), html.indexOf('How to redo this</h2>'));
  const words = (html) => shown(html).replace(/-?\d+(?:\.\d+)?(?:e[-+]?\d+)?/g, '#');
  assert.ok(shown(theirs).length > 1000, 'the report has a body');
  assert.equal(words(ours), words(theirs));
  const [numbers, wanted] = [ours, theirs].map((html) => numbersOf(shown(html)));
  const worst = difference(numbers, wanted);
  console.log(`# greatest relative difference of ${numbers.length} numbers of a report: ${worst}`);
  assert.ok(worst <= SAME, `${worst}`);
}

test('regress_nothing_leaves_the_page', async () => {
  const lab = await Page.open(chromium);
  const own = lab.connections().length;
  await lab.page.click('#example-rig');
  await lab.text('#inspection', /thrust_n/);
  await lab.tab('deck');
  await lab.text('#outcome', /Outcome/);
  assert.equal(lab.connections().length, own, 'no request after load');
  const refused = await lab.page.evaluate(() => fetch('/index.html').then(() => 'answered', () => 'refused'));
  assert.equal(refused, 'refused', 'the policy refuses a connection');
  await lab.close();
});

test('xval_a_table_of_a_thrust_stand_is_identified_as_by_the_command', withData, async () => {
  const lab = await Page.open(chromium);
  const log = join(data, 'thrust-5in-props-static', 'a1_11.csv');
  const map = join(root, 'examples', 'maps', 'thrust-5in-props-static.toml');
  await lab.drop(log);
  await lab.text('#inspection', /Columns|Channels/);
  await lab.page.$eval('#map-editor', (details) => (details.open = true));
  await lab.page.$eval(
    '#map',
    (area, text) => {
      area.value = text;
      area.dispatchEvent(new Event('input'));
    },
    readFileSync(map, 'utf8'),
  );
  await lab.text('#inspection', /throttle/);
  await lab.picture('log-table');
  await lab.tab('model');
  await lab.page.click('#identify');
  await lab.text('#identified', /Coefficients/);
  const { content } = await lab.saved('.card .save');
  const report = await lab.saved('#report');
  await lab.picture('model-thrust');
  const folder = mkdtempSync(join(tmpdir(), 'lab-'));
  touchdown('identify', 'thrust', log, '--map', map, '--out', folder);
  const expected = readFileSync(join(folder, 'a1_11.toml'), 'utf8');
  const page = readFileSync(join(folder, 'report.html'), 'utf8');
  rmSync(folder, { recursive: true });
  const terms = (text) => numbersOf(text.slice(text.indexOf('[[terms]]')));
  const worst = difference(terms(content.toString()), terms(expected));
  console.log(`# greatest relative difference of a card's numbers: ${worst}`);
  assert.ok(worst <= SAME, `${worst}`);
  assert.equal(report.name, 'report.html');
  sameReport(report.content.toString(), page);
  assert.deepEqual(lab.errors, []);
  await lab.close();
});

test('xval_a_ulog_has_the_channels_that_the_command_shows', withData, async () => {
  const lab = await Page.open(chromium);
  const log = join(data, 'log-px4-ulog', 'sample_log_small.ulg');
  await lab.drop(log);
  await lab.text('#inspection', /Topics/);
  await lab.picture('log-ulog');
  const shown = await lab.table('Channels');
  const { logs } = JSON.parse(touchdown('inspect', log, '--json'));
  const expected = logs[0].channels.columns;
  assert.equal(shown.length, expected.length);
  const numbers = [];
  const wanted = [];
  shown.forEach(([name, , values, , , least, median, greatest], k) => {
    assert.equal(name, expected[k].name);
    assert.equal(Number(values), expected[k].count);
    for (const [text, value] of [[least, expected[k].min], [median, expected[k].median], [greatest, expected[k].max]]) {
      if (value === null) continue;
      numbers.push(Number(text));
      wanted.push(value);
    }
  });
  const worst = difference(numbers, wanted);
  console.log(`# greatest relative difference of ${numbers.length} figures of channels: ${worst}`);
  assert.ok(worst <= SAME, `${worst}`);
  assert.deepEqual(lab.errors, []);
  await lab.close();
});

test('xval_a_landing_is_that_of_the_command', withCommand, async () => {
  const hash = '#deck=sea&height_m=0.3&period_s=5&wind_mps=2&strength=0.8&seed=7&landing=0';
  const lab = await Page.open(chromium, { hash });
  await lab.text('#outcome', /Outcome/);
  const shown = new Map((await lab.table('Outcome')).map(([name, first, second]) => [name, [first, second]]));
  const file = await lab.page.$eval('pre', (pre) => pre.textContent);
  const folder = mkdtempSync(join(tmpdir(), 'lab-'));
  writeFileSync(join(folder, 'scenario.toml'), file);
  const out = join(folder, 'out');
  const controllers = ['--controller', 'dynamic+observer', '--controller', 'feedback'];
  const mcaps = join(folder, 'mcap');
  touchdown('land', join(folder, 'scenario.toml'), '--space', ...controllers, '--trials', '1', '--out', out, '--mcap', mcaps);
  const trace = (await lab.saved('#mcap')).content;
  sameTrace(trace, readFileSync(join(mcaps, 'landing-000000.mcap')));
  const [header, ...rows] = readFileSync(join(out, 'landings.csv'), 'utf8').trim().split('\n').map((line) => line.split(','));
  rmSync(folder, { recursive: true });
  const numbers = [];
  const wanted = [];
  rows.forEach((row, side) => {
    const value = (name) => row[header.indexOf(name)];
    assert.equal(shown.get('Outcome')[side], value('outcome').replaceAll('_', ' '));
    for (const [name, words] of [
      ['t_l_s', 'Time of the descent (s)'],
      ['v_l_mps', 'Speed at the touch (m/s)'],
      ['lateral_m', 'Distance from the centre (m)'],
      ['tilt_rad', 'Tilt at the touch (rad)'],
      ['greatest_foot_n', 'Greatest force on a foot (N)'],
    ]) {
      if (value(name) === '') continue;
      numbers.push(Number(shown.get(words)[side]));
      wanted.push(Number(value(name)));
    }
  });
  const worst = difference(numbers, wanted);
  console.log(`# greatest relative difference of ${numbers.length} figures of two landings: ${worst}`);
  assert.ok(numbers.length > 4 && worst <= SAME, `${worst}`);
  assert.deepEqual(lab.errors, []);
  await lab.close();
});

test('regress_a_link_shows_the_same_landing', async () => {
  const first = await Page.open(chromium);
  await first.tab('deck');
  await first.text('#outcome', /Outcome/);
  await first.page.$eval('#height_m', (input) => {
    input.value = '0.6';
    input.dispatchEvent(new Event('input'));
  });
  await first.page.click('#fly');
  await first.page.waitForFunction(() => location.hash.includes('height_m=0.6'));
  await first.page.waitForFunction(() => !document.querySelector('#fly').disabled);
  const outcome = await first.table('Outcome');
  const hash = new URL(first.page.url()).hash;
  await first.close();
  const second = await Page.open(chromium, { hash });
  await second.text('#outcome', /Outcome/);
  assert.deepEqual(await second.table('Outcome'), outcome);
  await second.close();
});

test('prop_addresses_that_make_no_sense_show_a_landing', async () => {
  for (const hash of [
    '#deck=banana&first=nobody&second=dynamic+observer&wind_mps=abc&seed=-3&landing=1e9',
    '#height_m=NaN&seed=99999999999999999999&landing=-0.5',
    '#%E0%A4%A&=&&deck',
  ]) {
    const lab = await Page.open(chromium, { hash });
    await lab.text('#outcome', /Outcome/);
    assert.deepEqual(lab.errors, [], hash);
    await lab.close();
  }
});

test('regress_hostile_logs_are_errors_in_a_page_that_lives', async () => {
  const folder = mkdtempSync(join(tmpdir(), 'lab-'));
  const ulog = Buffer.concat([Buffer.from('554c6f67011235', 'hex'), Buffer.from([1]), Buffer.alloc(64, 255)]);
  const hostile = [
    ['empty.csv', Buffer.alloc(0)],
    ['noise.bin', Buffer.from(Array.from({ length: 4096 }, (_, k) => (k * 7919) % 256))],
    ['broken.ulg', ulog],
    ['script.csv', Buffer.from('time_s,<img src=x onerror=alert(1)>\n0,1\n1,2\n')],
    ['broken.parquet', Buffer.concat([Buffer.from('PAR1'), Buffer.alloc(200, 255), Buffer.from('PAR1')])],
    // Those that the readers are tested with, where `cargo test` has left them.
    ...(corpus ? readdirSync(corpus).map((name) => [name, readFileSync(join(corpus, name))]) : []),
  ];
  console.log(`# ${hostile.length} hostile files`);
  const lab = await Page.open(chromium);
  for (const [name, bytes] of hostile) {
    writeFileSync(join(folder, name), bytes);
    await lab.drop(join(folder, name));
    await lab.page.waitForFunction(
      (of) => {
        const shown = document.querySelector('#inspection').textContent;
        const state = document.querySelector('#log .state').textContent;
        return shown !== '' && !state.startsWith('Reading') && (state === '' || state.startsWith(of));
      },
      {},
      name,
    );
  }
  rmSync(folder, { recursive: true });
  await lab.page.click('#example-rig');
  await lab.text('#inspection', /thrust_n/);
  assert.deepEqual(lab.errors, []);
  await lab.close();
});

test('regress_an_identification_is_cancelled', async () => {
  const lab = await Page.open(chromium);
  await lab.page.click('#example-flights');
  await lab.text('#inspection', /throttle/);
  await lab.tab('model');
  await lab.page.select('#task', 'identify_ground_effect');
  await lab.page.type('#mass', '1.37');
  await lab.page.type('#radius', '0.12');
  await lab.page.click('#identify');
  await lab.page.waitForSelector('#cancel:not([hidden])');
  await lab.page.click('#cancel');
  await lab.text('#model', /Cancelled/);
  await lab.page.waitForFunction(() => !document.querySelector('#identify').disabled);
  await lab.close();
});

test('regress_from_flights_to_a_landing_with_their_card', async () => {
  const lab = await Page.open(chromium);
  await lab.page.click('#example-flights');
  await lab.text('#inspection', /throttle/);
  await lab.picture('log-flights');
  await lab.tab('model');
  await lab.page.select('#task', 'identify_ground_effect');
  await lab.page.type('#mass', '1.37');
  await lab.page.type('#radius', '0.12');
  await lab.page.click('#identify');
  await lab.text('#identified', /Coefficients/);
  await lab.page.$eval('#more-figures', (details) => (details.open = true));
  await lab.page.waitForFunction(() => document.querySelectorAll('#more-figures .plot canvas').length >= 12);
  await lab.picture('model-flights');
  await lab.page.click('.card .fly');
  await lab.tab('deck');
  await lab.text('#outcome', /Outcome/);
  assert.match(await lab.page.$eval('pre', (pre) => pre.textContent), /dynamic = "dynamic.toml"/);
  await lab.page.click('#crowd');
  await lab.text('#distribution', /of 100\b/);
  await lab.picture('deck-crowd');
  const mcap = await lab.saved('#mcap');
  assert.equal(mcap.content.subarray(1, 5).toString(), 'MCAP');
  assert.deepEqual(lab.errors, []);
  await lab.close();
});

test('regress_one_file_works_from_disk', async () => {
  const lab = await Page.open(chromium, { file: true });
  await lab.page.click('#example-rig');
  await lab.text('#inspection', /thrust_n/);
  await lab.tab('deck');
  await lab.text('#outcome', /Outcome/);
  assert.deepEqual(lab.errors, []);
  assert.equal(lab.connections().length, 1, 'the file itself');
  await lab.close();
});

test('regress_layout_at_three_widths_in_light_and_dark', async () => {
  // T = 20 σ², a table that is identified at once.
  const folder = mkdtempSync(join(tmpdir(), 'lab-'));
  const stand = join(folder, 'stand.csv');
  const rows = Array.from({ length: 21 }, (_, k) => [k, 0.2 + 0.03 * k, 20 * (0.2 + 0.03 * k) ** 2].join(','));
  writeFileSync(stand, ['time_s,throttle,thrust_n', ...rows].join('\n') + '\n');
  for (const [width, scheme] of [[360, 'light'], [1280, 'dark'], [3840, 'light']]) {
    const lab = await Page.open(chromium, { width, height: 900 });
    await lab.page.emulateMediaFeatures([
      { name: 'prefers-color-scheme', value: scheme },
      { name: 'prefers-reduced-motion', value: 'reduce' },
    ]);
    await lab.drop(stand);
    await lab.text('#inspection', /thrust_n/);
    const overflow = () =>
      lab.page.evaluate(() => document.documentElement.scrollWidth - document.documentElement.clientWidth);
    assert.equal(await overflow(), 0, `log at ${width}`);
    assert.deepEqual(await lab.page.evaluate(misplaced), [], `log at ${width}`);
    await lab.picture(`log-${width}`);
    await lab.tab('model');
    await lab.page.click('#identify');
    await lab.text('#identified', /Coefficients/);
    await lab.page.waitForSelector('.plot canvas');
    assert.equal(await overflow(), 0, `model at ${width}`);
    assert.deepEqual(await lab.page.evaluate(misplaced), [], `model at ${width}`);
    await lab.picture(`model-${width}`);
    await lab.tab('deck');
    await lab.text('#outcome', /Outcome/);
    await lab.page.$eval('#time', (input) => {
      input.value = String(Number(input.max) * 0.85);
      input.dispatchEvent(new Event('input'));
    });
    assert.equal(await overflow(), 0, `deck at ${width}`);
    assert.deepEqual(await lab.page.evaluate(misplaced), [], `deck at ${width}`);
    const columns = await lab.page.$$eval('#deck .columns > *', (all) => all.map((part) => part.getBoundingClientRect().toJSON()));
    const [first, second] = columns;
    // A phone has the parts below one another, a screen beside one another.
    if (width === 360) assert.ok(second.top >= first.bottom, 'stacked');
    else assert.ok(second.left >= first.right && second.top === first.top, 'side by side');
    await lab.picture(`deck-${width}`);
    await lab.close();
  }
  rmSync(folder, { recursive: true });
});

test('regress_tabs_by_keyboard', async () => {
  const lab = await Page.open(chromium);
  await lab.page.focus('#tab-log');
  await lab.page.keyboard.press('ArrowRight');
  assert.equal(await lab.page.$eval('#model', (panel) => panel.hidden), false);
  assert.equal(await lab.page.evaluate(() => document.activeElement.id), 'tab-model');
  await lab.close();
});
