// Landings in the background, with the distribution of touchdown speeds growing while one watches.

import { digits, el, failure, isCancelled, reason, refocus, table } from './dom';
import { shade } from './plots';
import { SCENARIO } from './scenario';
import type { Lab } from './state';

type Row = [string, string][];

interface Side {
  name: string;
  files: Map<string, Blob>;
}

const WANTED = 100;
/** Landings of one request: about a fifth of a second of work, so that the picture grows smoothly. */
const BLOCK = 5;
/** Greatest speed that the histogram shows (m/s): a touch of 0.6 m/s is a crash. */
const FASTEST = 0.6;
const BARS = 24;

export class Crowd {
  private running: AbortController | undefined;
  private readonly shown = el('div', { id: 'distribution' });
  /** What the landings that are shown or flown are of. */
  private of = '';

  constructor(private readonly lab: Lab) {}

  stop(): void {
    this.running?.abort();
  }

  /** Landings of something else are stopped, and shown no longer. */
  keep(of: string): void {
    if (of === this.of) return;
    this.stop();
    this.shown.replaceChildren();
  }

  /** The button and what it shows; `asked` gives the controllers when it is pressed, and what their landings are of; nothing where
   * the controls make no scenario. */
  panel(asked: () => { of: string; sides: Side[] } | undefined): HTMLElement {
    const start = el('button', { type: 'button', id: 'crowd' }, `Fly ${WANTED} landings`);
    const cancel = el('button', { type: 'button', id: 'crowd-cancel', hidden: true, onclick: () => this.stop() }, 'Cancel');
    const bar = el('progress', { max: 1, value: 0, hidden: true, 'aria-label': 'Landings flown' });
    const shown = this.shown;
    start.addEventListener('click', () => {
      const scenario = asked();
      if (!scenario) return;
      this.stop();
      const { of, sides } = scenario;
      this.of = of;
      const focus = refocus();
      const running = (this.running = new AbortController());
      start.disabled = true;
      bar.value = 0;
      cancel.hidden = bar.hidden = false;
      this.fly(sides, running.signal, bar, shown)
        .catch((error: unknown) => {
          if (!isCancelled(error)) shown.replaceChildren(failure(reason(error)));
        })
        .finally(() => {
          start.disabled = false;
          cancel.hidden = bar.hidden = true;
          focus();
        });
    });
    return el('div', {}, el('div', { class: 'row' }, start, cancel, bar), shown);
  }

  private async fly(sides: Side[], signal: AbortSignal, bar: HTMLProgressElement, shown: HTMLElement): Promise<void> {
    const rows: Row[][] = sides.map(() => []);
    const blocks: { side: number; from: number }[] = [];
    for (let from = 0; from < WANTED; from += BLOCK) {
      sides.forEach((_, side) => blocks.push({ side, from }));
    }
    const total = blocks.length;
    let done = 0;
    const work = async () => {
      for (let block = blocks.shift(); block; block = blocks.shift()) {
        const request = { task: 'landings', sweep: SCENARIO, from: block.from, to: block.from + BLOCK };
        const files = sides[block.side]!.files;
        const { result } = await this.lab.calculator.ask<Row[]>(request, files, signal);
        rows[block.side]!.push(...result);
        bar.value = ++done / total;
        shown.replaceChildren(summary(sides, rows), histogram(sides, rows));
      }
    };
    // One core stays with the page.
    const workers = Math.max(1, Math.min(navigator.hardwareConcurrency - 1, 8));
    await Promise.all(Array.from({ length: workers }, work));
  }
}

const cell = (row: Row, key: string) => row.find(([name]) => name === key)?.[1] ?? '';

function summary(sides: Side[], rows: Row[][]): HTMLElement {
  const share = (of: Row[], test: (outcome: string) => boolean) => {
    const count = of.filter((row) => test(cell(row, 'outcome'))).length;
    return `${count} of ${of.length}`;
  };
  const mean = (of: Row[], key: string) => {
    const values = of.map((row) => cell(row, key)).filter((text) => text !== '').map(Number);
    return values.length === 0 ? '–' : digits(values.reduce((a, b) => a + b, 0) / values.length);
  };
  return table(
    'Landings',
    ['', ...sides.map(({ name }) => name)],
    [
      ['Landed', ...rows.map((of) => share(of, (outcome) => outcome === 'landed'))],
      ['Crashed or tipped over', ...rows.map((of) => share(of, (o) => o === 'crashed' || o === 'tipped_over'))],
      ['Mean speed at the touch (m/s)', ...rows.map((of) => mean(of, 'v_l_mps'))],
      ['Mean distance from the centre (m)', ...rows.map((of) => mean(of, 'lateral_m'))],
    ],
  );
}

/** Histograms of the speed at the touch, one above the other. */
function histogram(sides: Side[], rows: Row[][]): SVGElement {
  const svg = (name: string, attributes: Record<string, string | number>, text = '') => {
    const made = document.createElementNS('http://www.w3.org/2000/svg', name);
    for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, String(value));
    made.textContent = text;
    return made;
  };
  const counts = rows.map((of) => {
    const bars = new Array<number>(BARS).fill(0);
    for (const row of of) {
      const text = cell(row, 'v_l_mps');
      if (text === '') continue;
      const at = Math.min(Math.floor((Math.abs(Number(text)) / FASTEST) * BARS), BARS - 1);
      bars[at]! += 1;
    }
    return bars;
  });
  const most = Math.max(1, ...counts.flat());
  const [width, height, left] = [480, 90, 4];
  const picture = svg('svg', {
    viewBox: `0 0 ${width} ${height * sides.length + 36}`,
    role: 'img',
    'aria-label': 'Distribution of the speed at the touch',
    class: 'histogram',
  });
  counts.forEach((bars, side) => {
    const base = height * (side + 1);
    picture.append(svg('text', { x: width - 4, y: base - height + 16, 'text-anchor': 'end' }, sides[side]!.name));
    bars.forEach((count, k) => {
      const step = (width - 2 * left) / BARS;
      const tall = (count / most) * (height - 14);
      const at = { x: left + k * step + 1, y: base - tall, width: step - 2, height: tall, fill: shade(side) };
      picture.append(svg('rect', at));
    });
    picture.append(svg('line', { x1: left, x2: width - left, y1: base, y2: base, class: 'axis' }));
  });
  const bottom = height * sides.length;
  for (const speed of [0, 0.1, 0.2, 0.3, 0.4, 0.5]) {
    const x = left + (speed / FASTEST) * (width - 2 * left);
    picture.append(svg('text', { x, y: bottom + 15, 'text-anchor': speed === 0 ? 'start' : 'middle' }, String(speed)));
  }
  const words = 'Speed at the touch (m/s); the last bar holds faster ones too';
  picture.append(svg('text', { x: width / 2, y: bottom + 32, 'text-anchor': 'middle' }, words));
  return picture as SVGElement;
}
