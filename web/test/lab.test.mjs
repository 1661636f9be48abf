import assert from 'node:assert/strict';
import { mkdtempSync, readFileSync, readdirSync, rmSync, writeFileSync } from 'node:fs';
import { connect } from 'node:net';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { test } from 'node:test';
import * as esbuild from 'esbuild';
import { data, difference, fixtures, Page, root, touchdown, withCommand, withData } from './browser.mjs';
import { serve } from '../serve.mjs';
import { chromiumForTests } from './chromium.mjs';

const corpus = process.env.TOUCHDOWN_CORPUS;

const chromium = chromiumForTests();

const withBoth = { skip: withData.skip || withCommand.skip };

/** Figures differ from the command's where the C library and the browser round exp, sin and log differently: in the
 * fourteenth digit, which a fit may amplify a thousandfold. */
const SAME = 1e-9;
/** All numbers of a text, in their order. */
const NUMBER = /-?\d+(?:\.\d+)?(?:e[-+]?\d+)?/g;
const numbersOf = (text) => [...text.matchAll(NUMBER)].map(([n]) => Number(n));
/** Greatest difference of the numbers of two cards' terms and scores, each over the greatest number of its table: one end of an
 * interval may lie near zero. */
function differenceOfCards(found, wanted) {
  const tables = (card) => card.slice(card.indexOf('[[terms]]')).split('[[');
  const wantedTables = tables(wanted);
  const words = (table) => table.replaceAll(NUMBER, '#');
  assert.deepEqual(tables(found).map(words), wantedTables.map(words));
  return Math.max(0, ...tables(found).map((table, k) => {
    const values = (of) => numbersOf(of.replaceAll(/".*"/g, ''));
    const [a, b] = [values(table), values(wantedTables[k])];
    const scale = Math.max(...b.map(Math.abs));
    return Math.max(0, ...a.map((x, n) => Math.abs(x - b[n]) / scale));
  }));
}

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

/** The long columns of a report's curves, which are 16-bit steps. */
const PACKED = /"packed":"([^"]*)"/g;

/** Two reports show the same words, tables and curves; only the paths in their commands differ. */
function sameReport(ours, theirs) {
  const body = (html) => html.slice(html.indexOf('<body'), html.indexOf('How to redo this</h2>'));
  const steps = (html) => [...body(html).matchAll(PACKED)].flatMap(([, text]) => {
    const bytes = Buffer.from(text, 'base64');
    return Array.from({ length: bytes.length / 2 }, (_, k) => bytes.readUInt16LE(2 * k));
  });
  const [found, expected] = [steps(ours), steps(theirs)];
  assert.equal(found.length, expected.length);
  assert.ok(found.every((step, k) => Math.abs(step - expected[k]) <= 1), 'the curves are those of the command, within a step of their columns');
  const shown = (html) => body(html).replace(PACKED, '');
  const words = (html) => shown(html).replace(/-?\d+(?:\.\d+)?(?:e[-+]?\d+)?/g, '#');
  assert.ok(shown(theirs).length > 1000, 'the report has a body');
  assert.equal(words(ours), words(theirs));
  const [numbers, wanted] = [ours, theirs].map((html) => numbersOf(shown(html)));
  const worst = difference(numbers, wanted);
  console.log(`# greatest relative difference of ${numbers.length} numbers of a report: ${worst}; ${found.length} steps of its curves`);
  assert.ok(worst <= SAME, `${worst}`);
}

/** What the page shows of a dropped log is what `touchdown inspect` finds: channels or columns, and topics. */
async function sameContent(lab, log, picture) {
  const name = log.split('/').at(-1);
  await lab.page.waitForFunction(
    (of) => document.querySelector('#log .state').textContent.startsWith(`${of}: `) || document.querySelector('#inspection .error'),
    {},
    name,
  );
  assert.equal(await lab.page.evaluate(() => document.querySelector('#inspection .error')?.textContent), undefined, name);
  if (picture) await lab.picture(picture);
  const [{ channels, columns, topics }] = JSON.parse(touchdown('inspect', log, '--json')).logs;
  const tables = [];
  const ofColumns = (all) => all.map((c) => [c.name, c.unit ?? '', c.count, c.gaps, c.rate_hz, c.min, c.median, c.max]);
  if (channels) tables.push(['Channels', ofColumns(channels.columns)]);
  else if (columns) tables.push(['Columns', ofColumns(columns)]);
  if (topics) tables.push(['Topics', topics.map((t) => [t.key, t.messages, t.rate_hz, t.gaps, t.fields.length])]);
  assert.ok(tables.length > 0, name);
  let count = 0;
  for (const [caption, wanted] of tables) {
    const shown = await lab.table(caption);
    assert.deepEqual(shown.map(([of]) => of), wanted.map(([of]) => of), `${name}: ${caption}`);
    shown.forEach((row, k) => row.forEach((text, column) => {
      const of = wanted[k][column];
      const where = `${name}: ${caption}, ${row[0]}, column ${column}: expected ${of}, found ${text}`;
      if (typeof of !== 'number') return assert.equal(text, of ?? '–', where);
      count += 1;
      assert.ok(difference([Number(text)], [of]) <= SAME, where);
    }));
  }
  console.log(`# ${name}: ${count} figures are those of the command`);
}

/** What the page has identified from flights is what the command identifies from the same logs: cards, numbers, routes, refusals, report. */
async function sameGroundEffect(lab, logs) {
  const folder = mkdtempSync(join(tmpdir(), 'lab-'));
  const paths = logs.map(({ name, content }) => {
    writeFileSync(join(folder, name), content);
    return join(folder, name);
  });
  const settings = join(folder, 'settings.toml');
  writeFileSync(settings, '[vehicle]\nmass_kg = 1.37\nrotor_radius_m = 0.12\n');
  const out = join(folder, 'out');
  const { flight } = JSON.parse(touchdown('identify', 'ground-effect', ...paths, '--settings', settings, '--out', out, '--json'));
  const read = (name) => readFileSync(join(out, name), 'utf8');
  const wantedCards = [read('ground-effect.toml'), read('thrust.toml')];
  const wantedReport = read('report.html');
  rmSync(folder, { recursive: true });
  const same = (what, worst) => {
    console.log(`# greatest relative difference of the numbers of ${what}: ${worst}`);
    assert.ok(worst <= SAME, `${what}: ${worst}`);
  };
  const compare = (what, found, wanted) => same(what, difference(found, wanted));
  assert.equal((await lab.page.$$('.card')).length, wantedCards.length, 'a card of the ground effect, and one of the thrust');
  for (const [k, wanted] of wantedCards.entries()) {
    const { name, content } = await lab.saved(`article.card:nth-of-type(${k + 1}) .save`);
    same(`the card ${name}`, differenceOfCards(content.toString(), wanted));
  }
  const numbers = await lab.table('Numbers of the model');
  assert.deepEqual(numbers.map(([name]) => name), flight.numbers.map(({ name }) => name.replaceAll('_', ' ')));
  compare('the model', numbers.map(([, value]) => Number(value)), flight.numbers.map(({ value }) => value));
  const titles = await lab.page.$$eval('table', (tables) => {
    const routes = tables.find((table) => table.caption?.textContent.startsWith('Routes'));
    return [...routes.querySelectorAll('span[title]')].map((span) => Number(span.title));
  });
  const lifts = flight.routes.flatMap(({ extra_lift: lift }) => lift);
  assert.ok(lifts.length > 0);
  const wantedLifts = lifts.flatMap(({ value, ci95, height_m }) => [100 * value, 100 * ci95[0], 100 * ci95[1], height_m]);
  compare('the routes', titles, wantedLifts);
  const routes = await lab.table('Routes');
  flight.routes.forEach(({ basis, taken, refused }, k) => {
    assert.match(routes[k][0], new RegExp(`^${String(basis).replaceAll('_', ' ')}${taken ? ' \\(taken\\)' : ''}$`));
    if (refused) assert.equal(routes[k][1], refused);
  });
  const refusals = await lab.table('Not identified');
  assert.deepEqual(refusals, flight.refused.map(({ what, found, record }) => [what, found, record]));
  const report = await lab.saved('#report');
  sameReport(report.content.toString(), wantedReport);
}

/** A DataFlash log of two messages: a barometer, with heights from 0 to 5 m at 10 Hz. */
function dataFlash() {
  const text = (of, length) => Buffer.concat([Buffer.from(of), Buffer.alloc(length)]).subarray(0, length);
  const format = (type, length, name, fields, labels) =>
    Buffer.concat([Buffer.from([0xa3, 0x95, 128, type, length]), text(name, 4), text(fields, 16), text(labels, 64)]);
  const message = (k) => {
    const bytes = Buffer.alloc(15);
    bytes.set([0xa3, 0x95, 150]);
    bytes.writeBigUInt64LE(BigInt(1_000_000 + 100_000 * k), 3);
    bytes.writeFloatLE(0.1 * k, 11);
    return bytes;
  };
  const messages = Array.from({ length: 51 }, (_, k) => message(k));
  return Buffer.concat([
    format(128, 89, 'FMT', 'BBnNZ', 'Type,Length,Name,Format,Columns'),
    format(150, 15, 'BARO', 'Qf', 'TimeUS,Alt'),
    ...messages,
  ]);
}

test('regress_nothing_leaves_the_page', async () => {
  const lab = await Page.open(chromium());
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

test('xval_a_table_of_a_thrust_stand_is_identified_as_by_the_command', withBoth, async () => {
  const lab = await Page.open(chromium());
  const log = join(data, 'thrust-5in-props-static', 'a1_11.csv');
  const map = join(root, 'examples', 'maps', 'thrust-5in-props-static.toml');
  await lab.drop(log);
  await lab.text('#inspection', /Columns|Channels/);
  await lab.map(readFileSync(map, 'utf8'));
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
  const worst = differenceOfCards(content.toString(), expected);
  console.log(`# greatest relative difference of a card's numbers: ${worst}`);
  assert.ok(worst <= SAME, `${worst}`);
  assert.equal(report.name, 'report.html');
  sameReport(report.content.toString(), page);
  assert.deepEqual(lab.errors, []);
  await lab.close();
});

test('xval_a_ulog_has_the_channels_that_the_command_shows', withBoth, async () => {
  const lab = await Page.open(chromium());
  const log = join(data, 'log-px4-ulog', 'sample_log_small.ulg');
  await lab.drop(log);
  await lab.text('#inspection', /Topics/);
  await lab.picture('log-ulog');
  await sameContent(lab, log, 'log-ulog');
  assert.deepEqual(lab.errors, []);
  await lab.close();
});

test('xval_logs_of_every_format_have_the_content_that_the_command_shows', withCommand, async () => {
  const folder = mkdtempSync(join(tmpdir(), 'lab-'));
  const own = [
    ['flight.bin', dataFlash()],
    ['stand.csv', 'time_s,throttle,thrust_n\n0,0.2,0.8\n0.01,0.5,5.125\n0.02,,9\n'],
  ].map(([name, content]) => {
    writeFileSync(join(folder, name), content);
    return join(folder, name);
  });
  const lab = await Page.open(chromium());
  for (const log of [...own, ...readdirSync(fixtures).sort().map((name) => join(fixtures, name))]) {
    await lab.drop(log);
    await sameContent(lab, log);
  }
  rmSync(folder, { recursive: true });
  assert.deepEqual(lab.errors, []);
  await lab.close();
});

test('xval_a_landing_is_that_of_the_command', withCommand, async () => {
  const hash = '#deck=sea&height_m=0.3&period_s=5&wind_mps=2&strength=0.8&seed=7&landing=0';
  const lab = await Page.open(chromium(), { hash });
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
  const first = await Page.open(chromium());
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
  const second = await Page.open(chromium(), { hash });
  await second.text('#outcome', /Outcome/);
  assert.deepEqual(await second.table('Outcome'), outcome);
  assert.equal(await second.page.$eval('#missing-cards', (box) => box.textContent), '');
  // Another address in the same page flies, and says which cards it lacks.
  await second.page.evaluate(() => (location.hash = '#height_m=0.1&seed=3&cards=thrust+dynamic'));
  await second.text('#missing-cards', /own cards \(thrust; ground effect\)/);
  await second.page.waitForFunction(() => !document.querySelector('#fly').disabled);
  const other = await second.table('Outcome');
  assert.notDeepEqual(other, outcome);
  assert.match(await second.page.$eval('pre', (pre) => pre.textContent), /^seed = 3$/m);
  assert.match(second.page.url(), /cards=thrust\+dynamic$/, 'the address stays that of the link');
  // A landing of the page's own controls is no longer that of the link.
  await second.page.click('#fly');
  await second.page.waitForFunction(() => !document.querySelector('#fly').disabled);
  assert.equal(await second.page.$eval('#missing-cards', (box) => box.textContent), '');
  assert.deepEqual(second.errors, []);
  await second.close();
});

test('regress_a_built_in_map_is_edited', async () => {
  const lab = await Page.open(chromium());
  await lab.page.click('#example-flights');
  await lab.text('#inspection', /throttle/);
  const channels = await lab.table('Channels');
  await lab.page.click('#use-map');
  await lab.text('#map-editor', /The map fits this log\./);
  assert.deepEqual(await lab.table('Channels'), channels, 'the built-in map as a text gives the same channels');
  await lab.page.$eval('#map', (area) => {
    area.value = area.value.replace('"throttle", ', '').replace(/^throttle = \[[^]*?^\]\n/m, '');
    area.dispatchEvent(new Event('input'));
  });
  await lab.page.waitForFunction(() => !document.querySelector('#inspection table').textContent.includes('throttle'));
  assert.deepEqual(lab.errors, []);
  await lab.close();
});

test('regress_reading_simulating_flying_and_recording_are_cancelled', async () => {
  const lab = await Page.open(chromium());
  await lab.page.evaluate(() => {
    const line = '0.123456,0.5,1.25\n';
    const file = new File(['time_s,throttle,thrust_n\n', line.repeat(2_000_000)], 'long.csv');
    const transfer = new DataTransfer();
    transfer.items.add(file);
    document.querySelector('.drop').dispatchEvent(new DragEvent('drop', { dataTransfer: transfer, bubbles: true }));
  });
  await lab.text('#log .state', /^Reading long\.csv/);
  await lab.page.click('#log-cancel');
  await lab.text('#log .state', /^Cancelled\./);
  await lab.page.click('#example-flights');
  await lab.page.click('#log-cancel');
  await lab.text('#log .state', /^Cancelled\./);
  assert.equal(await lab.page.$eval('#inspection', (box) => box.textContent), '');
  await lab.tab('deck');
  await lab.text('#outcome', /Outcome/);
  await lab.page.waitForFunction(() => !document.querySelector('#fly').disabled);
  for (const button of ['#fly', '#mcap']) {
    // A landing takes a fraction of a second: both presses come at once.
    await lab.page.evaluate((of) => {
      document.querySelector(of).click();
      document.querySelector('#fly-cancel').click();
    }, button);
    await lab.text('#deck-state', /^Cancelled\./);
    assert.equal(await lab.page.$eval('#fly-cancel', (cancel) => cancel.hidden), true);
    assert.equal(await lab.page.$eval(button, (of) => of.disabled), false);
  }
  // What cannot be recorded is told.
  await lab.page.evaluate(() => {
    Worker.prototype.postMessage = () => {
      throw new Error('no worker answers');
    };
  });
  await lab.page.click('#mcap');
  await lab.text('#deck-problem', /no worker answers/);
  assert.deepEqual(lab.errors, []);
  await lab.close();
});

test('regress_the_deck_is_told_apart_without_colours_and_by_keyboard', async () => {
  const lab = await Page.open(chromium());
  await lab.page.emulateMediaFeatures([{ name: 'prefers-reduced-motion', value: 'reduce' }]);
  await lab.tab('deck');
  await lab.text('#outcome', /Outcome/);
  const legend = () => lab.page.$$eval('.legend tbody tr', (rows) => rows.map((row) => [...row.cells].map((cell) => cell.textContent)));
  const forces = (row) => row[2].split(', ').map(Number);
  const begin = await legend();
  assert.deepEqual(begin.map(([name]) => name), ['Model and observer', 'Feedback, no model']);
  assert.deepEqual(begin.flatMap(forces), Array(8).fill(0), 'no foot stands at the start');
  await lab.page.$eval('#time', (input) => {
    input.value = input.max;
    input.dispatchEvent(new Event('input'));
  });
  for (const row of await legend()) {
    assert.match(row[1], /^-?\d+\.\d %$/);
    // A vehicle of 1.37 kg stands on its feet, on a deck that moves.
    const sum = forces(row).reduce((a, b) => a + b);
    assert.ok(sum > 5 && sum < 30, `${row}`);
  }
  const colours = await lab.page.$$eval('.legend .sample', (all) => all.map((sample) => sample.style.background));
  assert.equal(new Set(colours).size, 4, 'vehicle, ghost, disc and bars have colours of their own');
  const lines = await lab.page.$$eval('.charts .u-legend', (all) =>
    all.map((plot) => [...plot.querySelectorAll('.u-marker')].slice(1).map((marker) => getComputedStyle(marker).borderTopStyle)),
  );
  assert.deepEqual(lines, [['solid', 'dashed'], ['solid', 'dashed'], ['solid', 'dashed', 'dotted']]);
  const canvas = await lab.page.$('.view canvas');
  const picture = async () => (await canvas.screenshot()).toString('base64');
  /** The picture once it stands still: it is sharpened after a while. */
  const still = async () => {
    let [last, now] = ['', await picture()];
    while (last !== now) [last, now] = [now, await picture()];
    return now;
  };
  await canvas.focus();
  let last = await still();
  for (const keys of [['ArrowLeft'], ['Shift', 'ArrowLeft'], ['+']]) {
    for (const key of keys) await lab.page.keyboard.down(key);
    for (const key of keys) await lab.page.keyboard.up(key);
    const now = await still();
    assert.notEqual(now, last, keys.join(' '));
    last = now;
  }
  assert.deepEqual(lab.errors, []);
  await lab.close();
});

test('analytic_all_sides_fly_the_same_vehicle', async () => {
  const { outputFiles } = await esbuild.build({ entryPoints: [join(root, 'web', 'src', 'scenario.ts')], bundle: true, write: false, format: 'esm' });
  const source = `data:text/javascript;base64,${Buffer.from(outputFiles[0].contents).toString('base64')}`;
  const { DEFAULT, side, toml } = await import(source);
  const card = (use, vehicle) => ({ use, name: use, vehicle, toml: '' });
  const own = [card('thrust', { rotors: 6 }), card('dynamic', { mass_kg: 2, rotor_radius_m: 0.15 }), card('empirical', { mass_kg: 2 })];
  const file = (controller, model, cards = own) => {
    const of = side(controller, model, cards);
    const text = toml(DEFAULT, of);
    const table = (name) => text.match(new RegExp(`^\\[${name}\\]\n([^[]*)`, 'm'))?.[1].trim().split('\n') ?? [];
    return [of.controller, of.model, table('cards').map((line) => line.split(' ')[0]), table('vehicle')];
  };
  const all = ['thrust', 'dynamic', 'empirical'];
  const stated = ['mass_kg = 2.0', 'rotor_radius_m = 0.15'];
  assert.deepEqual(file('dynamic+observer', 'own'), ['dynamic+observer', 'own', all, []]);
  assert.deepEqual(file('dynamic+observer', 'none'), ['observer', 'none', all, []]);
  assert.deepEqual(file('dynamic', 'none'), ['feedback', 'none', all, []]);
  assert.deepEqual(file('empirical', 'own'), ['empirical', 'own', all, []]);
  assert.deepEqual(file('empirical', 'none'), ['feedback', 'none', all, []]);
  assert.deepEqual(file('dynamic', 'built_in'), ['dynamic', 'built_in', ['thrust'], stated]);
  assert.deepEqual(file('feedback', 'own'), ['feedback', 'none', all, []]);
  // A card of the empirical law alone sizes no vehicle of a sweep, and is no model of `dynamic`.
  assert.deepEqual(file('empirical', 'own', own.slice(2)), ['empirical', 'own', ['empirical'], ['mass_kg = 2.0']]);
  assert.deepEqual(file('dynamic', 'own', own.slice(2)), ['dynamic', 'built_in', ['empirical'], ['mass_kg = 2.0']]);
  assert.deepEqual(file('dynamic', 'own', []), ['dynamic', 'built_in', [], []]);
});

test('prop_addresses_that_make_no_sense_show_a_landing', async () => {
  for (const hash of [
    '#deck=banana&first=nobody&second=dynamic+observer&wind_mps=abc&seed=-3&landing=1e9',
    '#height_m=NaN&seed=99999999999999999999&landing=-0.5',
    '#%E0%A4%A&=&&deck',
    '#constructor=1&toString=2&__proto__=3&valueOf=4',
  ]) {
    const lab = await Page.open(chromium(), { hash });
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
  const lab = await Page.open(chromium());
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
  const lab = await Page.open(chromium());
  await lab.page.click('#example-flights');
  await lab.text('#inspection', /throttle/);
  await lab.groundEffectOfFlights();
  await lab.page.click('#identify');
  await lab.page.waitForSelector('#cancel:not([hidden])');
  await lab.page.click('#cancel');
  await lab.text('#model', /Cancelled/);
  await lab.page.waitForFunction(() => !document.querySelector('#identify').disabled);
  await lab.close();
});

test('regress_from_flights_to_a_landing_with_their_card', async () => {
  const lab = await Page.open(chromium());
  await lab.page.click('#example-flights');
  await lab.text('#inspection', /throttle/);
  await lab.picture('log-flights');
  const logs = await lab.allSaved('#save-logs', 4);
  await lab.groundEffectOfFlights();
  await lab.page.click('#identify');
  await lab.text('#identified', /Coefficients/);
  await lab.page.$eval('#more-figures', (details) => (details.open = true));
  await lab.page.waitForFunction(() => document.querySelectorAll('#more-figures .plot canvas').length >= 12);
  await lab.picture('model-flights');
  if (withCommand.skip) console.log(`# not compared with the command: ${withCommand.skip}`);
  else await sameGroundEffect(lab, logs);
  // The card flies beside the same controller without it.
  await lab.page.click('.card .fly');
  await lab.tab('deck');
  await lab.text('#outcome', /Outcome/);
  const header = () => lab.page.$$eval('#outcome thead th', (cells) => cells.slice(1).map((cell) => cell.textContent));
  const file = () => lab.page.$eval('pre', (pre) => pre.textContent);
  assert.deepEqual(await header(), ['Model and observer (own card)', 'Observer, no model']);
  assert.match(await file(), /dynamic = "dynamic.toml"/);
  assert.match(lab.page.url(), /cards=dynamic/);
  await lab.page.select('#first-model', 'built_in');
  await lab.page.select('#second', 'dynamic');
  await lab.page.select('#second-model', 'own');
  await lab.page.click('#fly');
  await lab.text('#outcome', /built-in/);
  assert.deepEqual(await header(), ['Model and observer (built-in)', 'Model (own card)']);
  assert.doesNotMatch(await file(), /dynamic.toml/);
  assert.match(await file(), /\[vehicle\]\nmass_kg = 1.37\nrotor_radius_m = 0.12\n/);
  await lab.page.click('#crowd');
  await lab.text('#distribution', /of 100\b/);
  await lab.picture('deck-crowd');
  const mcap = await lab.saved('#mcap');
  assert.equal(mcap.content.subarray(1, 5).toString(), 'MCAP');
  assert.deepEqual(lab.errors, []);
  await lab.close();
});

test('xval_a_force_rig_is_identified_as_by_the_command_and_its_empirical_law_flies', withCommand, async () => {
  const folder = mkdtempSync(join(tmpdir(), 'lab-'));
  const file = (name, lines) => {
    writeFileSync(join(folder, name), lines.join('\n') + '\n');
    return join(folder, name);
  };
  // T = 20 σ², and a ground effect that falls with the square of the height.
  const steps = Array.from({ length: 21 }, (_, k) => [k, 0.2 + 0.03 * k, 20 * (0.2 + 0.03 * k) ** 2].join());
  const stand = file('stand.csv', ['time_s,throttle,thrust_n', ...steps]);
  const rigs = [0, 1, 2].map((n) => {
    const rows = Array.from({ length: 800 }, (_, k) => {
      const t = k / 100;
      const [s, z] = [0.6 + 0.1 * Math.sin(1.3 * t + n), 0.35 + 0.25 * Math.sin(0.9 * t + 0.7 * n)];
      const thrust = 20 * s * s * (1 + (0.03 / z) ** 2) + 0.02 * Math.sin(37 * t + n);
      return [t, s, thrust, z, -0.225 * Math.cos(0.9 * t + 0.7 * n)].join();
    });
    return file(`rig-${n}.csv`, ['time_s,throttle,thrust_n,height_m,deck_velocity_mps', ...rows]);
  });
  const settings = '[vehicle]\nmass_kg = 1.37\nrotor_radius_m = 0.12\nrotors = 4\nmeasured_rotors = 4\n';
  const lab = await Page.open(chromium());
  await lab.drop(stand);
  await lab.text('#inspection', /thrust_n/);
  await lab.tab('model');
  await lab.page.$eval('#settings', (area, text) => (area.value = text), settings);
  await lab.page.click('#identify');
  await lab.text('#identified', /Coefficients/);
  const thrust = (await lab.saved('.card .save')).content.toString();
  await lab.page.click('.card .fly');
  await lab.tab('log');
  await lab.drop(...rigs);
  await lab.text('#inspection', /height_m/);
  await lab.tab('model');
  await lab.page.select('#task', 'identify_ground_effect');
  await lab.page.click('#identify');
  await lab.text('#identified', /Ground effect: /);
  const out = join(folder, 'out');
  const [card, set] = [file('thrust.toml', [thrust]), file('settings.toml', [settings])];
  touchdown('identify', 'ground-effect', ...rigs, '--thrust', card, '--settings', set, '--out', out);
  for (const [k, form] of ['empirical', 'static', 'derivative', 'ratio', 'lag'].entries()) {
    const { content } = await lab.saved(`article.card:nth-of-type(${k + 1}) .save`);
    const worst = differenceOfCards(content.toString(), readFileSync(join(out, `${form}.toml`), 'utf8'));
    console.log(`# greatest relative difference of the numbers of the card ${form}: ${worst}`);
    assert.ok(worst <= SAME, `${form}: ${worst}`);
  }
  sameReport((await lab.saved('#report')).content.toString(), readFileSync(join(out, 'report.html'), 'utf8'));
  rmSync(folder, { recursive: true });
  await lab.page.click('article.card:nth-of-type(1) .fly');
  await lab.tab('deck');
  await lab.text('#outcome', /Outcome/);
  const header = await lab.page.$$eval('#outcome thead th', (cells) => cells.slice(1).map((cell) => cell.textContent));
  assert.deepEqual(header, ['Empirical law (own card)', 'Feedback, no model']);
  const scenario = await lab.page.$eval('pre', (pre) => pre.textContent);
  assert.match(scenario, /^\[cards\]\nthrust = "thrust.toml"\nempirical = "empirical.toml"$/m);
  assert.match(scenario, /^controller = "empirical"$/m);
  assert.deepEqual(lab.errors, []);
  await lab.close();
});

test('regress_one_file_works_from_disk', async () => {
  const lab = await Page.open(chromium(), { file: true });
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
    const lab = await Page.open(chromium(), { width, height: 900 });
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

test('regress_forced_colours_leave_the_chosen_tab_and_the_samples', async () => {
  const lab = await Page.open(chromium());
  const client = await lab.page.createCDPSession();
  const features = [{ name: 'forced-colors', value: 'active' }, { name: 'prefers-reduced-motion', value: 'reduce' }];
  await client.send('Emulation.setEmulatedMedia', { features });
  await lab.tab('deck');
  await lab.text('#outcome', /Outcome/);
  const backs = (selector) => lab.page.$$eval(selector, (all) => all.map((one) => getComputedStyle(one).backgroundColor));
  const [chosen, other] = [await backs('[role=tab][aria-selected=true]'), await backs('[role=tab][aria-selected=false]')];
  assert.notEqual(chosen[0], other[0]);
  assert.equal(new Set(await backs('.legend .sample')).size, 4, 'vehicle, ghost, disc and bars have colours of their own');
  await lab.picture('deck-forced-colours');
  await lab.close();
});

test('regress_a_request_that_is_no_address_does_not_end_the_server', async () => {
  const server = await serve(0);
  const { port } = server.address();
  const answer = (path) =>
    new Promise((resolve, reject) => {
      const socket = connect(port, '127.0.0.1', () => socket.write(`GET ${path} HTTP/1.0\r\n\r\n`));
      let text = '';
      socket.on('data', (part) => (text += part));
      socket.on('end', () => resolve(Number(text.split(' ')[1])));
      socket.on('error', reject);
    });
  for (const [path, status] of [['//', 200], ['/?x=1', 200], ['/..', 404], ['/../serve.mjs', 404], ['/none.js', 404]]) {
    assert.equal(await answer(path), status, path);
  }
  await assert.rejects(serve(port), /EADDRINUSE/);
  server.close();
});

test('regress_tabs_by_keyboard', async () => {
  const lab = await Page.open(chromium());
  await lab.page.focus('#tab-log');
  await lab.page.keyboard.press('ArrowRight');
  assert.equal(await lab.page.$eval('#model', (panel) => panel.hidden), false);
  const focused = () => lab.page.evaluate(() => document.activeElement.id);
  assert.equal(await focused(), 'tab-model');
  await lab.page.keyboard.press('End');
  assert.equal(await focused(), 'tab-deck');
  await lab.page.keyboard.press('Home');
  assert.equal(await focused(), 'tab-log');
  await lab.close();
});

test('regress_what_is_saved_and_linked_is_what_is_shown', async () => {
  const lab = await Page.open(chromium());
  await lab.tab('deck');
  await lab.text('#outcome', /Outcome/);
  const flown = async () => lab.page.waitForFunction(() => !document.querySelector('#fly').disabled);
  const set = (value) =>
    lab.page.$eval('#height_m', (input, to) => {
      input.value = to;
      input.dispatchEvent(new Event('input'));
    }, value);
  await flown();
  const record = (await lab.saved('#mcap')).content;
  // The controls move, and nothing is flown.
  await set('1.2');
  await lab.page.click('#share');
  await lab.text('#deck-state', /has not flown/);
  assert.match(lab.page.url(), /height_m=0.4&/);
  assert.ok(record.equals((await lab.saved('#mcap')).content), 'the record of the landing that is shown');
  // A flight that is cancelled leaves the landing and its address.
  await lab.page.evaluate(() => {
    document.querySelector('#fly').click();
    document.querySelector('#fly-cancel').click();
  });
  await lab.text('#deck-state', /^Cancelled\. Below is the landing that was flown before\./);
  assert.match(lab.page.url(), /height_m=0.4&/);
  // A hundred landings stand beside one of them, and beside no other.
  await lab.page.click('#crowd');
  await lab.page.waitForFunction(() => /significant_height_m = 1.2,/.test(document.querySelector('pre').textContent));
  await lab.text('#distribution', /of \d/);
  assert.match(lab.page.url(), /height_m=1.2&/);
  await set('0.8');
  await lab.page.click('#fly');
  await flown();
  assert.equal(await lab.page.$eval('#distribution', (box) => box.textContent), '');
  // Every control has a name.
  const labels = await lab.page.$$eval('#deck .fields input, #deck .fields select', (all) => all.map((one) => one.labels.length));
  assert.deepEqual(labels, labels.map(() => 1));
  assert.ok(labels.length >= 12);
  assert.deepEqual(lab.errors, []);
  await lab.close();
});

test('regress_a_model_is_that_of_the_logs_that_were_asked_for', async () => {
  const lab = await Page.open(chromium());
  await lab.page.click('#example-flights');
  await lab.text('#inspection', /throttle/);
  await lab.groundEffectOfFlights();
  await lab.page.click('#identify');
  await lab.text('#model .state[role=status]', /^Identifying/);
  // Other logs come while it runs.
  const other = join(mkdtempSync(join(tmpdir(), 'lab-')), 'other.csv');
  writeFileSync(other, 'time_s,throttle,thrust_n\n0,0.1,1\n0.1,0.2,2\n0.2,0.3,3\n');
  await lab.drop(other);
  await lab.text('#model p.state', /other\.csv/);
  assert.equal(await lab.page.$eval('#identify', (button) => button.disabled), true, 'one at a time');
  await lab.text('#model .state[role=status]', /^Below is what was identified from .*\.ulg, before the logs or their map changed/);
  assert.equal(await lab.page.$eval('#identify', (button) => button.disabled), false);
  assert.deepEqual(lab.errors, []);
  await lab.close();
});
