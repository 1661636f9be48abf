// What a person types, links to and goes back to.
import assert from 'node:assert/strict';
import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, test } from 'node:test';
import { Page } from './browser.mjs';
import { chromiumForTests } from './chromium.mjs';

const chromium = chromiumForTests();

const folder = mkdtempSync(join(tmpdir(), 'lab-'));
after(() => rmSync(folder, { recursive: true }));

/** T = 20 σ², a table that is identified at once. */
function stand() {
  const rows = Array.from({ length: 21 }, (_, k) => [k, 0.2 + 0.03 * k, 20 * (0.2 + 0.03 * k) ** 2].join(','));
  const file = join(folder, 'stand.csv');
  writeFileSync(file, ['time_s,throttle,thrust_n', ...rows].join('\n') + '\n');
  return file;
}

/** Types into a field in place of what it holds. */
async function type(lab, field, text) {
  await lab.page.$eval(field, (input) => input.select());
  await lab.page.keyboard.press('Delete');
  await lab.page.type(field, text);
}

/** What a field says of itself to a screen reader. */
const said = (lab, field) =>
  lab.page.$eval(field, (input) => ({
    invalid: input.getAttribute('aria-invalid'),
    text: document.getElementById(input.getAttribute('aria-describedby'))?.innerText ?? '',
    focused: document.activeElement === input,
  }));

const flown = (lab) => lab.page.waitForFunction(() => !document.querySelector('#fly').disabled);
const scenario = (lab) => lab.page.$eval('pre', (pre) => pre.textContent);
const set = (lab, id, value) =>
  lab.page.$eval(
    id,
    (input, to) => {
      input.value = to;
      input.dispatchEvent(new Event('input'));
    },
    value,
  );

test('regress_a_number_that_cannot_be_is_an_error_beside_its_field', async () => {
  for (const [width, scheme] of [[360, 'dark'], [1280, 'light']]) {
    const lab = await Page.open(chromium(), { width });
    await lab.page.emulateMediaFeatures([{ name: 'prefers-color-scheme', value: scheme }]);
    await lab.drop(stand());
    await lab.text('#inspection', /thrust_n/);
    await lab.tab('model');
    for (const [field, text, expected] of [
      ['#mass', '1.37e', /expected a number from 0\.001 to 10000 with a decimal point, such as 1\.37; found “1\.37e”/],
      ['#mass', '1,37', /found “1,37”/],
      ['#mass', '1e9', /found “1e9”/],
      ['#radius', '-0.1', /found “-0\.1”/],
      ['#rotors', '4.5', /expected a whole number from 1 to 64, such as 4; found “4\.5”/],
    ]) {
      await type(lab, field, text);
      // However long the press: the message comes after it, and moves no button from under it.
      await lab.page.click('#identify', { delay: 500 });
      const { invalid, text: shown, focused } = await said(lab, field);
      assert.match(shown, expected);
      assert.equal(invalid, 'true');
      assert.ok(focused, 'the field has the focus');
      await lab.text('#model', /Nothing was identified/);
      assert.equal(await lab.page.$eval('#identified', (box) => box.textContent), '');
      if (text === '1,37') await lab.picture(`field-${width}-${scheme}`);
      // The message goes with its cause.
      await type(lab, field, field === '#mass' ? '1.37' : '');
      assert.deepEqual(await said(lab, field), { invalid: null, text: '', focused: true });
    }
    await lab.page.click('#identify');
    await lab.text('#identified', /Coefficients/);
    await lab.tab('deck');
    await lab.text('#outcome', /Outcome/);
    await flown(lab);
    const before = [await scenario(lab), lab.page.url()];
    await type(lab, '#landing', '1000');
    for (const button of ['#fly', '#crowd']) {
      await lab.page.click(button);
      assert.match((await said(lab, '#landing')).text, /expected a whole number from 0 to 999, such as 0; found “1000”/);
      assert.deepEqual([await scenario(lab), lab.page.url()], before, 'nothing flies');
    }
    await lab.text('#deck-state', /Nothing was flown/);
    await lab.picture(`field-deck-${width}-${scheme}`);
    await type(lab, '#landing', '2');
    await lab.page.click('#fly');
    await lab.page.waitForFunction(() => location.hash.includes('landing=2'));
    assert.deepEqual(lab.errors, []);
    await lab.close();
  }
});

test('regress_values_of_a_link_that_cannot_fly_are_named', async () => {
  const hash = '#deck=banana&height_m=99&wind_mps=abc&landing=5000&strength=0.51&colour=red&seed=7';
  for (const [width, scheme] of [[360, 'light'], [1280, 'dark']]) {
    const lab = await Page.open(chromium(), { hash, width });
    await lab.page.emulateMediaFeatures([{ name: 'prefers-color-scheme', value: scheme }]);
    const text = await lab.text('#link-faults', /cannot fly/);
    for (const line of [
      'deck: expected one of sea, sine, still; found “banana”. sea flies',
      'height_m: expected a number from 0.05 to 1.5 with a decimal point, such as 0.4, in steps of 0.05; found “99”. 1.5 flies',
      /wind_mps: .* found “abc”\. 3 flies/,
      /landing: .* found “5000”\. 999 flies/,
      /strength: .* found “0\.51”\. 0\.5 flies/,
      'colour: expected a value of a scenario; found “red”',
    ]) {
      assert.ok(typeof line === 'string' ? text.includes(line) : line.test(text), `${line}: ${text}`);
    }
    assert.doesNotMatch(text, /seed/);
    await lab.text('#outcome', /Outcome/);
    await flown(lab);
    assert.match(lab.page.url(), /height_m=1\.5&.*wind_mps=3&.*landing=999/, 'the address is that of what flies');
    await lab.picture(`link-${width}-${scheme}`);
    await lab.page.click('#fly');
    await flown(lab);
    assert.equal(await lab.page.$eval('#link-faults', (box) => box.textContent), '');
    assert.deepEqual(lab.errors, []);
    await lab.close();
  }
});

test('regress_back_returns_to_the_scenario_flown_before', async () => {
  const lab = await Page.open(chromium());
  await lab.tab('deck');
  await lab.text('#outcome', /Outcome/);
  await flown(lab);
  for (const height of ['0.6', '0.8']) {
    await set(lab, '#height_m', height);
    await lab.page.click('#fly');
    await lab.page.waitForFunction((of) => location.hash.includes(`height_m=${of}&`), {}, height);
    await flown(lab);
  }
  const entries = await lab.page.evaluate(() => history.length);
  await lab.page.click('#fly');
  await flown(lab);
  assert.equal(await lab.page.evaluate(() => history.length), entries, 'the same scenario is no step');
  for (const [move, height] of [['goBack', '0.6'], ['goBack', '0.4'], ['goForward', '0.6']]) {
    await lab.page[move]();
    await lab.page.waitForFunction(
      (of) => document.querySelector('pre').textContent.includes(`significant_height_m = ${of},`),
      {},
      height,
    );
    assert.match(lab.page.url(), new RegExp(`height_m=${height}&`));
    await flown(lab);
    assert.equal(await lab.page.$eval('#height_m', (input) => input.value), height);
  }
  assert.deepEqual(lab.errors, []);
  await lab.close();
});

test('regress_a_button_keeps_the_focus_through_its_work', async () => {
  const lab = await Page.open(chromium());
  await lab.drop(stand());
  await lab.text('#inspection', /thrust_n/);
  await lab.tab('model');
  const focused = () => lab.page.evaluate(() => document.activeElement.id);
  await lab.page.focus('#identify');
  await lab.page.keyboard.press('Enter');
  await lab.text('#identified', /Coefficients/);
  assert.equal(await focused(), 'identify');
  await lab.tab('deck');
  await lab.text('#outcome', /Outcome/);
  await flown(lab);
  await lab.page.focus('#fly');
  await lab.page.keyboard.press('Enter');
  await lab.text('#deck-state', /^Flown/);
  await flown(lab);
  assert.equal(await focused(), 'fly');
  await lab.page.focus('#crowd');
  await lab.page.keyboard.press('Enter');
  await lab.page.waitForFunction(() => document.querySelector('#crowd').disabled);
  await lab.page.waitForFunction(() => !document.querySelector('#crowd').disabled);
  assert.equal(await focused(), 'crowd');
  await lab.close();
});

test('regress_a_card_file_flies_and_a_removed_card_is_on_no_deck', async () => {
  const lab = await Page.open(chromium());
  await lab.drop(stand());
  await lab.text('#inspection', /thrust_n/);
  await lab.tab('model');
  await type(lab, '#mass', '0.5');
  await type(lab, '#rotors', '4');
  await lab.page.$eval('#settings', (area) => (area.value = ''));
  await lab.page.click('#identify');
  await lab.text('#identified', /Coefficients/);
  const button = () => lab.page.$eval('.card .fly', (fly) => fly.textContent);
  const saved = await lab.saved('.card .save');
  const file = join(folder, saved.name);
  writeFileSync(file, saved.content);
  await lab.page.click('.card .fly');
  assert.equal(await button(), 'On the deck: step 3');
  await lab.tab('deck');
  await lab.page.click('.cards button');
  await lab.text('.cards', /The built-in models fly/);
  assert.equal(await lab.page.evaluate(() => document.activeElement.id), 'add-card', 'the focus stays beside the list');
  assert.equal(await button(), 'Fly it on the deck');
  await lab.text('#outcome', /Outcome/);
  await flown(lab);
  // The file brings it back, and another file is an error with its name.
  const other = join(folder, 'other.toml');
  writeFileSync(other, 'schema = 1\nname = "none"\n');
  const input = await lab.page.$('#card-files');
  await input.uploadFile(file, other);
  await lab.text('.cards', /Thrust: stand/);
  await lab.text('#card-problem', /^other\.toml: /);
  await lab.page.click('#fly');
  await flown(lab);
  await lab.page.waitForFunction(() => document.querySelector('pre').textContent.includes('thrust = "thrust.toml"'));
  assert.equal(await lab.page.$eval('#deck-problem', (box) => box.textContent), '');
  await lab.picture('deck-card-file');
  assert.deepEqual(lab.errors, []);
  await lab.close();
});

test('regress_a_landing_that_is_shown_takes_the_colours_of_the_page', async () => {
  const lab = await Page.open(chromium());
  const scheme = (value) =>
    lab.page.emulateMediaFeatures([
      { name: 'prefers-color-scheme', value },
      { name: 'prefers-reduced-motion', value: 'reduce' },
    ]);
  await scheme('light');
  await lab.tab('deck');
  await lab.text('#outcome', /Outcome/);
  await flown(lab);
  await set(lab, '#time', '2.5');
  const colours = () => lab.page.$$eval('.legend tbody .sample', (samples) => samples.map((sample) => sample.style.background));
  const light = await colours();
  await scheme('dark');
  // The first vehicle's blue is too dark for a dark page; the second one's orange is not.
  await lab.page.waitForFunction((before) => document.querySelector('.legend tbody .sample').style.background !== before, {}, light[0]);
  const dark = await colours();
  assert.equal(dark[1], light[1]);
  assert.equal(await lab.page.$eval('#time', (input) => input.value), '2.5', 'it stays where it was in time');
  const line = await lab.page.$eval('.charts .u-legend .u-series:nth-child(2) .u-marker', (marker) => marker.style.borderColor);
  assert.equal(line, dark[0]);
  assert.deepEqual(lab.errors, []);
  await lab.close();
});
