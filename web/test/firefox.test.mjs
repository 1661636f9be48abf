// The lab in Firefox: the same steps, without what only Chromium's protocol can ask for.
import assert from 'node:assert/strict';
import { existsSync } from 'node:fs';
import { after, before, test } from 'node:test';
import puppeteer from 'puppeteer-core';
import { PATIENCE_MS, Page } from './browser.mjs';

const executablePath = process.env.FIREFOX ?? '/usr/bin/firefox-esr';
const options = { skip: !existsSync(executablePath) && `Firefox is not there (${executablePath})` };

let firefox;
before(async () => {
  if (options.skip) return;
  firefox = await puppeteer.launch({ browser: 'firefox', executablePath, protocolTimeout: PATIENCE_MS });
});
after(() => firefox?.close());

test('regress_firefox_identifies_a_rig', options, async () => {
  const lab = await Page.open(firefox);
  const own = lab.connections().length;
  await lab.page.click('#example-rig');
  await lab.text('#inspection', /thrust_n/);
  await lab.tab('model');
  await lab.page.click('#identify');
  await lab.text('#identified', /Coefficients/);
  await lab.page.waitForSelector('.plot canvas');
  await lab.picture('firefox-model');
  assert.equal(lab.connections().length, own, 'no request after load');
  assert.deepEqual(lab.errors, []);
  await lab.close();
});

test('regress_firefox_shows_the_landing_of_a_link', options, async () => {
  const lab = await Page.open(firefox, { hash: '#deck=sea&height_m=0.3&period_s=5&wind_mps=2&seed=7&landing=0' });
  await lab.text('#outcome', /Outcome/);
  const [row] = (await lab.table('Outcome')).filter(([name]) => name === 'Outcome');
  assert.deepEqual(row.slice(1), ['landed', 'landed']);
  // Without a graphics card Firefox has no WebGL 2: the page says so, and shows all else.
  const drawn = await lab.page.evaluate(() => document.querySelector('.view canvas') !== null);
  const said = await lab.page.evaluate(() => document.querySelector('.view').textContent);
  assert.equal(said, drawn ? '' : 'This browser cannot draw in three dimensions (WebGL 2).');
  await lab.picture('firefox-deck');
  assert.deepEqual(lab.errors, []);
  await lab.close();
});
