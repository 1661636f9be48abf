// Maps, what the page says of them, and in whose words.
import assert from 'node:assert/strict';
import { appendFileSync, mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, test } from 'node:test';
import { memory, Page } from './browser.mjs';
import { chromiumForTests } from './chromium.mjs';

const chromium = chromiumForTests();

const folder = mkdtempSync(join(tmpdir(), 'lab-'));
after(() => rmSync(folder, { recursive: true }));

function file(name, text) {
  writeFileSync(join(folder, name), text);
  return join(folder, name);
}

test('regress_a_map_that_fails_shows_no_channels_of_another', async () => {
  const lab = await Page.open(chromium());
  await lab.drop(file('stand.csv', 'time_s,throttle,thrust_n\n0,0.2,1\n1,0.3,2\n2,0.4,3\n'));
  await lab.text('#inspection', /Channels/);
  await lab.map("schema = 1\n[channels]\ntime_s = 'time_s'\nthrust_n = 'trust_n'\n");
  const text = await lab.text('#inspection', /no column "trust_n"/);
  assert.doesNotMatch(text, /Channels/);
  await lab.text('#map-editor', /No channels by this map/);
  await lab.map("schema = 1\n[channels]\ntime_s = 'time_s'\nthrust_n = '2 * thrust_n'\n");
  await lab.text('#inspection', /Channels/);
  await lab.text('#map-editor', /The map fits this log\./);
  assert.deepEqual(lab.errors, []);
  await lab.close();
});

test('regress_a_log_that_misses_the_zone_is_taken', async () => {
  const lab = await Page.open(chromium());
  await lab.page.evaluate(() => {
    const transfer = new DataTransfer();
    transfer.items.add(new File(['time_s,throttle\n0,0.1\n1,0.2\n'], 'missed.csv'));
    const event = new DragEvent('drop', { dataTransfer: transfer, bubbles: true, cancelable: true });
    document.querySelector('#inspection').dispatchEvent(event);
  });
  await lab.text('#log .state', /^missed\.csv: /);
  assert.equal(await lab.page.$eval('#which-log', (choice) => choice.options.length), 1, 'once');
  await lab.drop(file('stand.csv', 'time_s,throttle\n0,0.1\n1,0.2\n'));
  await lab.text('#log .state', /^stand\.csv: /);
  assert.deepEqual(lab.errors, []);
  await lab.close();
});

test('regress_a_map_as_typed_is_that_of_the_model_at_once', async () => {
  const rows = Array.from({ length: 21 }, (_, k) => `${k},${0.2 + 0.03 * k},${20 * (0.2 + 0.03 * k) ** 2}`);
  const lab = await Page.open(chromium());
  await lab.drop(file('stand.csv', ['time_s,throttle,thrust_n', ...rows].join('\n') + '\n'));
  await lab.text('#inspection', /Channels/);
  await lab.map("schema = 1\n[channels]\ntime_s = 'time_s'\nthrottle = 'throttle'\nthrust_n = 'thrust_n'\n");
  await lab.text('#map-editor', /The map fits this log\./);
  await lab.page.focus('#map');
  for (const key of ['ArrowLeft', 'ArrowLeft']) await lab.page.keyboard.press(key);
  await lab.page.keyboard.type(' * 4');
  await lab.tab('model');
  await lab.page.click('#identify');
  await lab.text('#identified', /Coefficients/);
  const slope = (await lab.table('Coefficients')).find(([term]) => term === 'x: s')[1];
  assert.ok(Math.abs(Number(slope) - Math.sqrt(80)) < 1e-6, slope);
  await lab.text('#model .state[role=status]', /^Identified/);
  assert.deepEqual(lab.errors, []);
  await lab.close();
});

test('regress_a_suggested_map_without_a_time_says_what_is_missing', async () => {
  const rows = Array.from({ length: 200 }, (_, k) => `${(0.4 + 0.1 * Math.sin(k)).toFixed(4)},${(5 + Math.sin(k)).toFixed(4)}`);
  for (const [width, scheme] of [[360, 'dark'], [1280, 'light']]) {
    const lab = await Page.open(chromium(), { width });
    await lab.page.emulateMediaFeatures([{ name: 'prefers-color-scheme', value: scheme }]);
    await lab.drop(file('no-time.csv', ['Throttle,Thrust (N)', ...rows].join('\n') + '\n'));
    await lab.text('#inspection', /Columns/);
    await lab.page.click('#use-map');
    await lab.text('#map-editor', /not complete: no column looks like the time.*remove the #.*seconds from one row to the next/);
    assert.match(await lab.page.$eval('#inspection', (box) => box.textContent), /Columns/, 'what is in the table stays');
    const chosen = await lab.page.$eval('#map', (area) => area.value.slice(area.selectionStart, area.selectionEnd));
    assert.match(chosen, /^# time_s = /, 'the line is chosen');
    await lab.picture(`map-without-time-${width}-${scheme}`);
    const map = await lab.page.$eval('#map', (area) => area.value);
    await lab.map(map.replace('# time_s = ', 'time_s = ').replace('0.01', '0.02'));
    await lab.text('#map-editor', /The map fits this log\./);
    const channels = await lab.table('Channels');
    assert.deepEqual(channels.map(([name]) => name), ['time_s', 'throttle', 'thrust_n']);
    assert.deepEqual(lab.errors, []);
    await lab.close();
  }
});

test('regress_errors_are_in_words_of_the_page', async () => {
  const lab = await Page.open(chromium());
  const foreign = /--\w|\/in\/|\/out\//;
  const of = async (selector) => {
    const text = await lab.text(`${selector} .error`, /./);
    assert.doesNotMatch(text, foreign);
    return text;
  };
  await lab.drop(file('leer.csv', ''));
  assert.match(await of('#inspection'), /^leer\.csv: expected a header and rows, found an empty file/);
  await lab.page.click('#example-flights');
  await lab.text('#inspection', /throttle/);
  await lab.tab('model');
  await lab.page.click('#identify');
  assert.match(await of('#identified'), /the field Mass \(kg\)/);
  await lab.page.select('#task', 'identify_ground_effect');
  await lab.page.type('#mass', '1.37');
  await lab.page.click('#identify');
  assert.match(await of('#identified'), /the field Rotor radius \(m\)/);
  await lab.close();
});

test('regress_an_identification_says_what_it_does', async () => {
  const lab = await Page.open(chromium());
  await lab.page.click('#example-flights');
  await lab.text('#inspection', /throttle/);
  await lab.groundEffectOfFlights();
  await lab.page.evaluate(() => {
    const state = document.querySelector('#model .state[role=status]');
    window.states = [];
    new MutationObserver(() => window.states.push(state.textContent)).observe(state, { childList: true, characterData: true, subtree: true });
  });
  await lab.page.click('#identify');
  await lab.text('#identified', /Coefficients/);
  const states = (await lab.page.evaluate(() => window.states)).join('\n');
  for (const stage of [
    /Reading simulated-landing-0\.ulg \(1 of 4\)/,
    /Reading simulated-landing-3\.ulg \(4 of 4\)/,
    /Fitting the ground effect by each route/,
    /Drawing the report/,
  ]) {
    assert.match(states, stage);
  }
  assert.deepEqual(lab.errors, []);
  await lab.close();
});

/** Waits for work of step 1 to end. */
const read = (lab) => lab.page.waitForFunction(() => document.querySelector('#log-cancel').hidden);

test('regress_a_large_table_with_a_map_is_read_in_bounded_memory', async () => {
  const columns = Array.from({ length: 30 }, (_, k) => `c${k}`);
  const [rows, blocks] = [1_000_000, 100];
  const line = `${columns.map((_, k) => `1.${100_000 + k}`.slice(0, 7)).join()}\n`;
  // A file of the disk: the bytes of other ones may be held by the browser.
  const large = file('large.csv', `${columns.join()}\n`);
  const block = line.repeat(rows / blocks);
  for (let k = 0; k < blocks; k++) appendFileSync(large, block);
  const lab = await Page.open(chromium());
  const before = memory(chromium());
  let most = 0;
  const watch = setInterval(() => (most = Math.max(most, memory(chromium()))), 100);
  await (await lab.page.$('#files')).uploadFile(large);
  await lab.text('#inspection', /Columns/);
  await lab.map("schema = 1\n[channels]\ntime_s = 'row * 0.01'\nthrust_n = 'c3 + c4'\n");
  await lab.text('#inspection', /Channels/);
  clearInterval(watch);
  const size = (rows * line.length) / 1e6;
  console.log(`# a table of ${size} MB with a map of two channels: from ${before} to ${most} MB`);
  // Two channels are 16 MB, slices of the file that are read and those before some 16 MB, a part of 4 MB with its columns 20 MB, and the
  // program some tens. Chromium kept every slice, which is the whole file, and the channels stood beside their columns.
  assert.ok(most - before < size / 2, `from ${before} to ${most} MB`);
  rmSync(large);
  assert.deepEqual(lab.errors, []);
  await lab.close();
});

test('regress_a_file_that_is_gone_is_told_and_a_file_is_chosen_again', async () => {
  const lab = await Page.open(chromium());
  const text = 'time_s,throttle,thrust_n\n0,0.2,1\n1,0.3,2\n2,0.4,3\n';
  const choose = async (path) => (await lab.page.$('#files')).uploadFile(path);
  await choose(file('gone.csv', text));
  await lab.text('#inspection', /Channels/);
  // Of a field that still holds it, a browser reports no change.
  assert.equal(await lab.page.$eval('#files', (input) => input.value), '');
  rmSync(join(folder, 'gone.csv'));
  await lab.map("schema = 1\n[channels]\ntime_s = 'time_s'\nthrottle = 'throttle'\n");
  assert.match(
    await lab.text('#inspection .error', /./),
    /^gone\.csv: the browser can no longer read this file: it was changed, moved or deleted since it was dropped, or it is a folder\. Drop it again\.$/,
  );
  await choose(file('gone.csv', text));
  await lab.text('#inspection', /Channels/);
  await read(lab);
  assert.deepEqual(lab.errors, []);
  await lab.close();
});

test('regress_settings_of_a_vehicle_stand_beside_the_fields', async () => {
  const lab = await Page.open(chromium());
  await lab.drop(file('stand.csv', ['time_s,throttle,thrust_n', ...Array.from({ length: 21 }, (_, k) => `${k},${0.2 + 0.03 * k},${20 * (0.2 + 0.03 * k) ** 2}`)].join('\n')));
  await lab.text('#inspection', /Channels/);
  await lab.tab('model');
  await lab.page.type('#mass', '1.37');
  const settings = (text) =>
    lab.page.$eval('#settings', (area, to) => {
      area.closest('details').open = true;
      area.value = to;
    }, text);
  await settings('[vehicle]\narm_m = 0.2\nmeasured_rotors = 1\n');
  await lab.page.click('#identify');
  await lab.text('#identified', /Coefficients/);
  await settings('[vehicle]\nmass_kg = 1.4\n');
  await lab.page.click('#identify');
  assert.match(await lab.text('#identified .error', /./), /expected one mass_kg; found 1\.37 in the field Mass \(kg\) and 1\.4 in the table \[vehicle\]/);
  assert.deepEqual(lab.errors, []);
  await lab.close();
});
