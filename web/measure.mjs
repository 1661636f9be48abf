// How fast the lab is in headless Chromium with a software renderer, and how much memory a large log takes:
// node measure.mjs [MEGABYTES OF THE LARGE LOG]
import { closeSync, mkdtempSync, openSync, rmSync, writeSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { Page, browser, memory } from './test/browser.mjs';

const megabytes = Number(process.argv[2] ?? 1000);
const runs = 5;
/** Seconds of a landing that is played. */
const PLAYED_S = 5;

/** A map of three of the table's five columns. */
const MAP = `schema = 1
[channels]
time_s = 'time_s'
throttle = 'throttle'
thrust_n = 'thrust_n'
`;

const median = (values) => values.toSorted((a, b) => a - b)[Math.floor(values.length / 2)];

/** A table of throttle and thrust of about so many bytes. */
function largeTable(path, bytes) {
  const file = openSync(path, 'w');
  writeSync(file, 'time_s,throttle,thrust_n,battery_v,height_m\n');
  let at = 0;
  for (let written = 0; written < bytes; ) {
    let text = '';
    for (let k = 0; k < 20_000; k++, at++) {
      const throttle = 0.5 + 0.3 * Math.sin(0.001 * at);
      text += `${(0.005 * at).toFixed(3)},${throttle.toFixed(6)},${(20 * throttle ** 2).toFixed(6)},15.800000,1.000000\n`;
    }
    written += writeSync(file, text);
  }
  closeSync(file);
}

const chromium = await browser();
try {
  const paints = [];
  const ready = [];
  for (let k = 0; k < runs; k++) {
    const lab = await Page.open(chromium);
    await lab.page.waitForFunction(() => performance.getEntriesByName('first-contentful-paint').length > 0);
    const times = await lab.page.evaluate(() => ({
      paint: performance.getEntriesByName('first-contentful-paint')[0].startTime,
      ready: performance.getEntriesByName('ready')[0].startTime,
    }));
    paints.push(times.paint);
    ready.push(times.ready);
    await lab.close();
  }
  console.log(`first paint ${median(paints).toFixed(0)} ms, ready to calculate ${median(ready).toFixed(0)} ms (medians of ${runs})`);

  const lab = await Page.open(chromium, { width: 1280, height: 720 });
  await lab.tab('deck');
  await lab.text('#outcome', /Outcome/);
  const frames = await lab.page.evaluate(async (seconds) => {
    const time = document.querySelector('#time');
    time.value = String(Math.max(Number(time.min), Number(time.max) - seconds));
    time.dispatchEvent(new Event('input'));
    document.querySelector('#play').click();
    const from = performance.now();
    let count = 0;
    while (performance.now() - from < 1000 * (seconds - 1)) {
      await new Promise((resolve) => requestAnimationFrame(resolve));
      count += 1;
    }
    const canvas = document.querySelector('.view canvas');
    return { rate: (1000 * count) / (performance.now() - from), size: [canvas.width, canvas.height] };
  }, PLAYED_S);
  console.log(`a landing plays with ${frames.rate.toFixed(0)} frames a second in ${frames.size.join('×')} pixels of a window of 1280×720`);
  await lab.close();

  const folder = mkdtempSync(join(tmpdir(), 'lab-'));
  const table = join(folder, 'large.csv');
  largeTable(table, 1e6 * megabytes);
  const large = await Page.open(chromium);
  const before = memory(chromium);
  let most = 0;
  const watch = setInterval(() => (most = Math.max(most, memory(chromium))), 200);
  const since = performance.now();
  await (await large.page.$('#files')).uploadFile(table);
  await large.text('#log', /rows|error|Error|cannot|memory/i);
  await large.picture('large');
  const said = (what, from) =>
    console.log(`${what} after ${((performance.now() - from) / 1000).toFixed(0)} s with ${most.toFixed(0)} MB of memory (${before.toFixed(0)} MB before)`);
  said(`a table of ${megabytes} MB is shown`, since);
  most = 0;
  const mapped = performance.now();
  await large.map(MAP);
  await large.text('#inspection', /Channels/);
  clearInterval(watch);
  said('its channels by a map of three of its columns', mapped);
  await large.close();
  rmSync(folder, { recursive: true });
} finally {
  await chromium.close();
}
