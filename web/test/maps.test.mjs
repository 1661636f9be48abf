// Maps, what the page says of them, and in whose words.
import assert from 'node:assert/strict';
import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
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
  await lab.text('#map-editor', /the map does not fit/);
  await lab.map("schema = 1\n[channels]\ntime_s = 'time_s'\nthrust_n = '2 * thrust_n'\n");
  await lab.text('#inspection', /Channels/);
  await lab.text('#map-editor', /The map fits this log\./);
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

test('regress_a_large_table_with_a_map_is_read_in_bounded_memory', async () => {
  const columns = Array.from({ length: 30 }, (_, k) => `c${k}`);
  const [rows, bytes] = [1_000_000, 30 * 8];
  const lab = await Page.open(chromium());
  await lab.dropLines('large.csv', `${columns.join()}\n`, `${columns.map((_, k) => `1.${100_000 + k}`.slice(0, 7)).join()}\n`, rows);
  await lab.text('#inspection', /Columns/);
  const before = memory(chromium());
  let most = 0;
  const watch = setInterval(() => (most = Math.max(most, memory(chromium()))), 100);
  await lab.map("schema = 1\n[channels]\ntime_s = 'row * 0.01'\nthrust_n = 'c3 + c4'\n");
  await lab.text('#inspection', /Channels/);
  clearInterval(watch);
  const size = (rows * bytes) / 1e6;
  console.log(`# a table of ${size} MB with a map of two columns: from ${before} to ${most} MB`);
  // Two columns and two channels are 32 MB, the program takes some tens, and slices of the file that the browser has not yet let
  // go of some more. The table as a whole took two and a half times its size.
  assert.ok(most - before < size, `from ${before} to ${most} MB`);
  assert.deepEqual(lab.errors, []);
  await lab.close();
});
