// The scene's legend: what disc and bars mean, with the numbers of every vehicle at the shown time.

import { el } from './dom';
import { FOOT, rowAt, WAKE, type Watched } from './scene';

/** A vehicle's ground effect in % of its weight, and the force on each foot in N, at a row. */
function numbers({ frames, weight_n }: Watched, row: number): [string, string] {
  const share = (100 * frames.ground_effect_n[row]!) / weight_n;
  return [`${share.toFixed(1)} %`, frames.feet_n[row]!.map((force) => force.toFixed(1)).join(', ')];
}

export class Legend {
  readonly element: HTMLElement;
  private readonly body = el('tbody');
  private vehicles: { landing: Watched; cells: HTMLElement[] }[] = [];

  constructor() {
    const head = el(
      'tr',
      {},
      el('th', { scope: 'col' }, 'Vehicle'),
      el('th', { scope: 'col' }, sample(WAKE), 'Disc: ground effect over weight'),
      el('th', { scope: 'col' }, sample(FOOT), 'Bars: force on each foot (N)'),
    );
    this.element = el('div', { class: 'legend' }, el('table', {}, el('thead', {}, head), this.body));
  }

  /** Takes the landings of a scene; the disc shows the first one's ground effect. */
  load(landings: Watched[], colours: string[], names: string[]): void {
    this.vehicles = landings.map((landing) => ({ landing, cells: [el('td'), el('td')] }));
    const rows = this.vehicles.map(({ cells }, k) =>
      el('tr', {}, el('th', { scope: 'row' }, sample(colours[k] ?? '#888'), names[k] ?? ''), ...cells),
    );
    this.body.replaceChildren(...rows);
  }

  show(time_s: number): void {
    for (const { landing, cells } of this.vehicles) {
      const texts = numbers(landing, rowAt(landing.frames, time_s));
      cells.forEach((cell, k) => (cell.textContent = texts[k]!));
    }
  }
}

/** A square of a colour. */
function sample(colour: string): HTMLElement {
  const square = el('span', { class: 'sample' });
  square.style.background = colour;
  return square;
}
