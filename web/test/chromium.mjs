// The browser of a file of tests.
import { mkdirSync } from 'node:fs';
import { after, before } from 'node:test';
import { browser, pictures } from './browser.mjs';

/** Starts Chromium before the tests of a file and ends it after them; what this returns gives it to a test. */
export function chromiumForTests() {
  let chromium;
  before(async () => {
    mkdirSync(pictures, { recursive: true });
    chromium = await browser();
  });
  after(() => chromium?.close());
  return () => chromium;
}
