// Step 2: model cards from the logs, with what they rest on and what the data do not say.

import { digits, download, el, failure, isCancelled, number, reason, refocus, table, warnings } from './dom';
import { checkAll, NumberField } from './field';
import { figure, type Plot } from './plots';
import { useOf, type CardFile, type CardText, type Lab, type LogFile } from './state';

interface Term {
  of: string;
  expression: string;
  value: number;
  std_error?: number | null;
  ci95?: [number, number] | null;
  unit: string;
  mark?: string | null;
}

interface Card extends CardText {
  equation: string;
  terms: Term[];
  warnings: string[];
}

interface Fit {
  card: Card;
  toml: string;
  rmse: number;
  rmse_unit: string;
  rows_used: number;
  lag_s: number | null;
  forms: { held_out_rmse_n: number | null; form?: string; chosen: boolean }[];
}

interface Estimate {
  value: number;
  ci95: [number, number];
}

interface Flight {
  curve: string;
  blocks: number;
  intervals_from: string;
  numbers: ({ name: string; unit: string } & Estimate)[];
  routes?: { basis: unknown; taken: boolean; extra_lift: ({ height_m: number } & Estimate)[]; refused: string | null }[];
  refused: { what: string; found: string; record: string }[];
}

export interface Identified {
  cards: Fit[];
  failed: [string, string][];
  flight: Flight | null;
  figures: Plot[][];
  report: string;
  warnings: string[];
  rows_dropped: number;
}

/** Distance of routes at one height in their figure, over the greatest height. */
const BESIDE = 0.015;
/** Figures that stand open; the others are behind a line. */
const SHOWN = 2;

const TASKS = [
  ['identify_thrust', 'Thrust: throttle to force'],
  ['identify_ground_effect', 'Ground effect: extra lift over height'],
] as const;

export function modelStep(panel: HTMLElement, lab: Lab): void {
  const task = el('select', { id: 'task' }, ...TASKS.map(([value, text]) => el('option', { value }, text)));
  const mass = new NumberField('mass', 'Mass (kg)', { min: 0.001, max: 10_000, optional: true, example: '1.37' });
  const radius = new NumberField('radius', 'Rotor radius (m)', { min: 0.001, max: 20, optional: true, example: '0.12' });
  const rotors = new NumberField('rotors', 'Rotors', { min: 1, max: 64, whole: true, optional: true, example: '4' });
  const settings = el('textarea', { id: 'settings', rows: 4, spellcheck: 'false' });
  const start = el('button', { type: 'button', id: 'identify', class: 'primary' }, 'Identify');
  const cancel = el('button', { type: 'button', id: 'cancel', hidden: true }, 'Cancel');
  const state = el('p', { role: 'status', class: 'state' });
  const shown = el('div', { id: 'identified' });
  let running: AbortController | undefined;
  const names = () => lab.logs.map((log) => log.name).join(', ');
  /** The logs, and the map, of what is shown. */
  let identified: { names: string; logs: LogFile[]; map: string } | undefined;
  /** Buttons of the cards that are shown. */
  let flying: FlyButton[] = [];

  async function identify(): Promise<void> {
    if (!checkAll([mass, radius, rotors])) {
      state.textContent = 'Nothing was identified: a field above is marked, and says what it takes.';
      return;
    }
    running?.abort();
    const focus = refocus();
    const own = (running = new AbortController());
    const asked = { names: names(), logs: [...lab.logs], map: lab.map };
    const { paths, files } = lab.files();
    const vehicle = { mass_kg: mass.value(), rotor_radius_m: radius.value(), rotors: rotors.value() };
    const data = { logs: paths, map: lab.map === '' ? null : lab.map, settings: settings.value, vehicle };
    const request =
      task.value === 'identify_thrust'
        ? { task: task.value, ...data }
        : { task: task.value, data, thrust: lab.card('thrust')?.toml ?? null };
    cancel.hidden = false;
    start.disabled = true;
    shown.replaceChildren();
    identified = undefined;
    const since = performance.now();
    let stage = '';
    const tick = () => {
      const seconds = ((performance.now() - since) / 1000).toFixed(0);
      state.textContent = `Identifying … ${seconds} s${stage === '' ? '' : `. ${stage} …`}`;
    };
    tick();
    const clock = setInterval(tick, 1000);
    try {
      const { result } = await lab.calculator.ask<Identified>(request, files, own.signal, (text) => {
        stage = text;
        tick();
      });
      state.textContent = `Identified in ${((performance.now() - since) / 1000).toFixed(1)} s.`;
      flying = result.cards.map((fit) => flyButton(fit, lab));
      shown.replaceChildren(...content(result, flying));
      update();
      identified = asked;
    } catch (error) {
      // Another identification has begun: the page shows that.
      if (running !== own) return;
      state.textContent = isCancelled(error) ? 'Cancelled.' : '';
      if (!isCancelled(error)) shown.replaceChildren(failure(reason(error)));
    } finally {
      clearInterval(clock);
      if (running === own) {
        running = undefined;
        cancel.hidden = true;
        update();
        focus();
      }
    }
  }

  start.addEventListener('click', () => void identify());
  cancel.addEventListener('click', () => running?.abort());
  const logs = el('p', { class: 'state' });
  const update = () => {
    start.disabled = lab.logs.length === 0 || running !== undefined;
    for (const { element, card } of flying) {
      element.textContent = lab.cards.includes(card) ? 'On the deck: step 3' : 'Fly it on the deck';
    }
    logs.textContent =
      lab.logs.length === 0 ? 'No logs yet: step 1 takes them.' : `Logs: ${names()}`;
    if (!identified) return;
    const same =
      identified.map === lab.map &&
      identified.logs.length === lab.logs.length &&
      identified.logs.every((log, k) => log === lab.logs[k]);
    if (!same) state.textContent = `Below is what was identified from ${identified.names}, before the logs or their map changed.`;
  };
  lab.watch(update);
  update();
  const field = (label: string, input: HTMLElement) => el('label', { class: 'field', for: input.id }, label, input);
  panel.append(
    logs,
    el(
      'div',
      { class: 'fields' },
      field('Model', task),
      mass.element,
      radius.element,
      rotors.element,
    ),
    el(
      'details',
      {},
      el('summary', {}, 'More settings'),
      el('label', { for: 'settings' }, 'As TOML, with the keys of `touchdown settings identify`'),
      settings,
    ),
    el('div', { class: 'row' }, start, cancel),
    state,
    shown,
  );
}

function content(of: Identified, flying: FlyButton[]): Node[] {
  const parts: (Node | null)[] = [];
  const save = () => download('report.html', of.report, 'text/html');
  parts.push(
    el('div', { class: 'row' }, el('button', { type: 'button', id: 'report', onclick: save }, 'Download the report')),
  );
  if (of.flight) parts.push(...flight(of.flight));
  parts.push(...of.figures.slice(0, SHOWN).flat().map(figure));
  of.cards.forEach((fit, k) => parts.push(card(fit, flying[k]!.element)));
  const more = of.figures.slice(SHOWN);
  if (more.length > 0) {
    const summary = el('summary', {}, more.length === 1 ? 'One more figure' : `${more.length} more figures`);
    parts.push(el('details', { id: 'more-figures' }, summary, ...more.flat().map(figure)));
  }
  if (of.failed.length > 0) parts.push(table('Forms that could not be fitted', ['Form', 'Why'], of.failed));
  parts.push(warnings('Of the logs', of.warnings));
  return parts.filter((part): part is Node => part !== null);
}

const interval = ([low, high]: [number, number]) => `${digits(low)} to ${digits(high)}`;

function flight(of: Flight): (Node | null)[] {
  const numbers = of.numbers.map((n) => [n.name.replaceAll('_', ' '), number(n.value), interval(n.ci95), n.unit]);
  const refused = of.refused.map((r) => [r.what, r.found, r.record]);
  const routes = (of.routes ?? []).map((r) => [
    `${basis(r.basis)}${r.taken ? ' (taken)' : ''}`,
    r.refused ??
      el('div', {}, ...r.extra_lift.map(({ value, ci95: [low, high], height_m }) => {
        const [lift, from, to] = [value, low, high].map((share) => number(100 * share));
        return el('div', {}, lift!, ' % (', from!, ' to ', to!, ') at ', number(height_m), ' m');
      })),
  ]);
  return [
    table(
      `Numbers of the model (intervals from ${of.blocks} ${of.intervals_from.replaceAll('_', ' ')})`,
      ['Number', 'Value', '95 % interval', 'Unit'],
      numbers,
    ),
    routes.length > 0 ? table('Routes to the ground effect', ['Thrust from', 'Extra lift'], routes) : null,
    routesFigure(of.routes ?? []),
    refused.length > 0
      ? table('Not identified', ['What', 'What the logs show', 'What to record'], refused)
      : null,
  ];
}

/** Extra lift by every route that has one, with intervals; nothing where there are not two. */
function routesFigure(of: NonNullable<Flight['routes']>): HTMLElement | null {
  const found = of.filter((route) => route.extra_lift.length > 0);
  if (found.length < 2) return null;
  const most = Math.max(...found.flatMap((route) => route.extra_lift.map((lift) => lift.height_m)));
  return figure({
    title: 'Routes side by side',
    caption: 'Extra lift near the ground by each route, with its 95 % interval. Routes at one height are drawn beside one another.',
    x: 'Height (m)',
    y: 'Extra lift (%)',
    series: found.map(({ basis: from, taken, extra_lift: lifts }, k) => ({
      name: `${basis(from)}${taken ? ' (taken)' : ''}`,
      style: 'points',
      x: lifts.map((lift) => lift.height_m + (k - (found.length - 1) / 2) * BESIDE * most),
      y: lifts.map((lift) => 100 * lift.value),
      bars: lifts.map(({ ci95 }) => [100 * ci95[0], 100 * ci95[1]]),
    })),
  });
}

/** A route by its name: `"accelerometer"`, or `{"hovers": …}`. */
function basis(of: unknown): string {
  if (typeof of === 'string') return of.replaceAll('_', ' ');
  return JSON.stringify(of).replace(/[{}"]/g, '').replaceAll('_', ' ');
}

/** A button that puts a card on the deck. */
interface FlyButton {
  element: HTMLElement;
  card: CardFile;
}

function flyButton({ card, toml }: Fit, lab: Lab): FlyButton {
  const file = { use: useOf(card), name: card.name, vehicle: card.vehicle, toml };
  return { element: el('button', { type: 'button', class: 'fly', onclick: () => lab.put(file) }), card: file };
}

function card(fit: Fit, fly: HTMLElement): HTMLElement {
  const { card, toml } = fit;
  const rows = card.terms.map((term) => [
    `${term.of}: ${term.expression}`,
    number(term.value),
    term.ci95 ? interval(term.ci95) : (term.mark ?? '–').replaceAll('_', ' '),
    term.unit,
  ]);
  const lag = fit.lag_s === null ? '' : `, lag ${digits(fit.lag_s)} s`;
  return el(
    'article',
    { class: 'card' },
    el('h2', {}, `${card.kind === 'thrust' ? 'Thrust' : 'Ground effect'}: ${card.name}`),
    el('p', {}, `${card.equation} (${card.form.replaceAll('_', ' ')}${lag})`),
    el('p', {}, `Residual ${digits(fit.rmse)} ${fit.rmse_unit} (RMS) over ${fit.rows_used} rows.`),
    table('Coefficients', ['Term', 'Value', '95 % interval', 'Unit'], rows),
    warnings('Before you rely on it', card.warnings),
    el(
      'div',
      { class: 'row' },
      fly,
      el(
        'button',
        { type: 'button', class: 'save', onclick: () => download(`${card.name}.toml`, toml, 'application/toml') },
        'Download the card',
      ),
    ),
  );
}
