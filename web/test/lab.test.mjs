import assert from 'node:assert/strict';
import { mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { browser, data, difference, hasCommand, Page, pictures, root, touchdown } from './browser.mjs';

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
  await lab.picture('model-thrust');
  const folder = mkdtempSync(join(tmpdir(), 'lab-'));
  touchdown('identify', 'thrust', log, '--map', map, '--out', join(folder, 'card.toml'));
  const expected = readFileSync(join(folder, 'card.toml'), 'utf8');
  rmSync(folder, { recursive: true });
  const terms = (text) => numbersOf(text.slice(text.indexOf('[[terms]]')));
  const worst = difference(terms(content.toString()), terms(expected));
  console.log(`# greatest relative difference of a card's numbers: ${worst}`);
  assert.ok(worst <= SAME, `${worst}`);
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
  touchdown('land', join(folder, 'scenario.toml'), '--space', ...controllers, '--trials', '1', '--out', out);
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

test('regress_hostile_logs_are_errors_in_a_page_that_lives', async () => {
  const folder = mkdtempSync(join(tmpdir(), 'lab-'));
  const ulog = Buffer.concat([Buffer.from('554c6f67011235', 'hex'), Buffer.from([1]), Buffer.alloc(64, 255)]);
  const hostile = [
    ['empty.csv', Buffer.alloc(0)],
    ['noise.bin', Buffer.from(Array.from({ length: 4096 }, (_, k) => (k * 7919) % 256))],
    ['broken.ulg', ulog],
    ['script.csv', Buffer.from('time_s,<img src=x onerror=alert(1)>\n0,1\n1,2\n')],
    ['broken.parquet', Buffer.concat([Buffer.from('PAR1'), Buffer.alloc(200, 255), Buffer.from('PAR1')])],
  ];
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
    await lab.picture(`log-${width}`);
    await lab.tab('model');
    await lab.page.click('#identify');
    await lab.text('#identified', /Coefficients/);
    await lab.page.waitForSelector('.plot canvas');
    assert.equal(await overflow(), 0, `model at ${width}`);
    await lab.picture(`model-${width}`);
    await lab.tab('deck');
    await lab.text('#outcome', /Outcome/);
    await lab.page.$eval('#time', (input) => {
      input.value = String(Number(input.max) * 0.85);
      input.dispatchEvent(new Event('input'));
    });
    assert.equal(await overflow(), 0, `deck at ${width}`);
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
