// Routes to the ground effect side by side.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { Page, pictures } from './browser.mjs';
import { chromiumForTests } from './chromium.mjs';

const chromium = chromiumForTests();

/** Gives the second route, which the example's flights do not identify, numbers near those of the first. */
function twoRoutes() {
  const { set } = Object.getOwnPropertyDescriptor(Worker.prototype, 'onmessage');
  Object.defineProperty(Worker.prototype, 'onmessage', {
    set(listener) {
      set.call(this, (event) => {
        const routes = event.data.result?.flight?.routes;
        if (routes) {
          routes[1].refused = null;
          routes[1].extra_lift = routes[0].extra_lift.map((lift) => ({
            ...lift,
            value: 1.2 * lift.value,
            ci95: [lift.ci95[0] - 0.01, lift.ci95[1] + 0.01],
          }));
        }
        listener(event);
      });
    },
  });
}

test('regress_routes_are_drawn_beside_one_another_with_their_intervals', async () => {
  for (const [width, scheme] of [[360, 'dark'], [1280, 'light']]) {
    const lab = await Page.open(chromium(), { width });
    await lab.page.emulateMediaFeatures([{ name: 'prefers-color-scheme', value: scheme }]);
    await lab.page.evaluate(twoRoutes);
    await lab.page.click('#example-flights');
    await lab.text('#inspection', /throttle/);
    await lab.groundEffectOfFlights();
    await lab.page.click('#identify');
    await lab.text('#identified', /Coefficients/);
    const routes = await lab.page.waitForSelector('[aria-label^="Routes side by side"] canvas');
    const legend = await lab.page.$eval('[aria-label^="Routes side by side"] .u-legend', (box) => box.textContent);
    assert.match(legend, /accelerometer \(taken\).*poses/s);
    // The bars of both routes, in their colours, are many times as long as their points are wide (6 pixels).
    const colours = await routes.evaluate((canvas) => {
      const { width: across, height: down } = canvas;
      const { data } = canvas.getContext('2d').getImageData(0, 0, across, down);
      const rows = {};
      for (let k = 0; k < data.length; k += 4) {
        const colour = [data[k], data[k + 1], data[k + 2]].join();
        (rows[colour] ??= new Set()).add(Math.floor(k / 4 / across));
      }
      return Object.fromEntries(Object.entries(rows).map(([colour, set]) => [colour, set.size]));
    });
    const blue = scheme === 'dark' ? '86,180,233' : '0,114,178';
    for (const colour of [blue, '213,94,0']) assert.ok(colours[colour] > 36, `${colour}: ${colours[colour]} rows`);
    assert.equal(await lab.page.evaluate(() => document.documentElement.scrollWidth - document.documentElement.clientWidth), 0);
    await (await lab.page.$('[aria-label^="Routes side by side"]')).screenshot({ path: `${pictures}/routes-${width}-${scheme}.png` });
    assert.deepEqual(lab.errors, []);
    await lab.close();
  }
});
