// Step 3: landings of two controllers on the same deck.

import type uPlot from 'uplot';
import { download, el, failure, isCancelled, number, reason, table } from './dom';
import { draw, shade, type Plot } from './plots';
import { CONTROLLERS, DECKS, fromHash, LANDINGS, NOBODY, toHash, toml, whole, type Scenario } from './scenario';
import { phaseAt, viewIn, type View, type Landing } from './scene';
import { Playback } from './playback';
import { Crowd } from './crowd';
import type { Lab } from './state';

const SLIDERS = [
  ['height_m', 'Wave height, or amplitude (m)', 0, 1.5, 0.05],
  ['period_s', 'Period (s)', 2, 15, 0.5],
  ['wind_mps', 'Wind (m/s)', 0, 12, 0.5],
  ['strength', 'Ground effect (1: the paper’s)', 0, 2, 0.05],
  ['delay_s', 'Delay of commands (s)', 0, 0.1, 0.005],
] as const;
/** Figures of a landing that the table shows. */
const ROWS = [
  ['outcome', 'Outcome'],
  ['why', 'Why'],
  ['t_l_s', 'Time of the descent (s)'],
  ['v_l_mps', 'Speed at the touch (m/s)'],
  ['impact_mps', 'Hardest touch (m/s)'],
  ['lateral_m', 'Distance from the centre (m)'],
  ['tilt_rad', 'Tilt at the touch (rad)'],
  ['greatest_foot_n', 'Greatest force on a foot (N)'],
] as const;

export function deckStep(panel: HTMLElement, lab: Lab): { shown(): void } {
  let scenario = fromHash(location.hash);
  /** Null where the browser cannot draw one: all else is shown. */
  let view: View | null | undefined;
  let landings: Landing[] = [];
  let plots: uPlot[] = [];
  const still = matchMedia('(prefers-reduced-motion: reduce)');
  const options = (of: readonly (readonly [string, string])[]) =>
    of.map(([value, text]) => el('option', { value }, text));
  const selects = {
    deck: el('select', { id: 'deck-motion' }, ...options(DECKS)),
    first: el('select', { id: 'first' }, ...options(CONTROLLERS)),
    second: el('select', { id: 'second' }, ...options(CONTROLLERS), el('option', { value: NOBODY }, 'Nobody')),
  };
  const integer = (id: string) => el('input', { id, type: 'number', min: 0, step: 1 });
  const numbers = { seed: integer('seed'), landing: integer('landing') };
  numbers.landing.max = String(LANDINGS - 1);
  const sliders = SLIDERS.map(([key, label, min, max, step]) => {
    const input = el('input', { id: key, type: 'range', min, max, step });
    const value = el('output', { for: key });
    input.addEventListener('input', () => (value.textContent = input.value));
    return { key, label, input, value };
  });
  const fly = el('button', { type: 'button', id: 'fly', class: 'primary' }, 'Fly');
  const play = el('button', { type: 'button', id: 'play', disabled: true }, 'Play');
  const record = el('button', { type: 'button', id: 'mcap', disabled: true }, 'Download MCAP');
  const share = el('button', { type: 'button', id: 'share' }, 'Copy link');
  const time = el('input', { type: 'range', id: 'time', min: 0, max: 1, step: 0.01, value: 0, 'aria-label': 'Time' });
  const now = el('output', { for: 'time' }, '0.00 s');
  const state = el('p', { role: 'status', class: 'state', id: 'deck-state' });
  const box = el('div', { class: 'view' });
  const charts = el('div', { class: 'charts' });
  const outcome = el('div', { id: 'outcome' });
  const cards = el('ul', { class: 'cards' });
  const file = el('pre', { tabindex: 0 });
  const crowd = new Crowd(lab);
  const playback = new Playback(play, time, seek);

  function fill(): void {
    for (const [key, select] of Object.entries(selects)) select.value = String(scenario[key as keyof Scenario]);
    for (const { key, input, value } of sliders) {
      input.value = String(scenario[key]);
      value.textContent = input.value;
    }
    numbers.seed.value = String(scenario.seed);
    numbers.landing.value = String(scenario.landing);
  }

  function read(): void {
    scenario = {
      ...scenario,
      deck: selects.deck.value as Scenario['deck'],
      first: selects.first.value,
      second: selects.second.value,
      seed: whole(Number(numbers.seed.value), Number.MAX_SAFE_INTEGER),
      landing: whole(Number(numbers.landing.value), LANDINGS - 1),
    };
    for (const { key, input } of sliders) scenario[key] = Number(input.value);
  }

  /** Files of the scenario for a controller: it and the cards that fly. */
  function files(controller: string): Map<string, Blob> {
    const own = lab.cards.map((card) => [card.kind === 'thrust' ? 'thrust' : 'dynamic', card.toml] as const);
    const text = toml(scenario, controller, own.map(([kind]) => kind));
    const all: [string, string][] = [['in/sweep.toml', text], ...own.map(([kind, of]): [string, string] => [`in/${kind}.toml`, of])];
    return new Map(all.map(([name, content]) => [name, new Blob([content])]));
  }

  const controllers = () => [scenario.first, scenario.second].filter((name) => name !== NOBODY);
  const label = (name: string) => CONTROLLERS.find(([value]) => value === name)?.[1] ?? name;

  async function start(): Promise<void> {
    read();
    history.replaceState(null, '', `#${toHash(scenario)}`);
    crowd.stop();
    playback.stop();
    fly.disabled = true;
    state.textContent = 'Flying …';
    const since = performance.now();
    try {
      const request = { task: 'land', sweep: '/in/sweep.toml', landing: scenario.landing };
      const answers = await Promise.all(
        controllers().map((name) => lab.calculator.ask<Landing>(request, files(name))),
      );
      landings = answers.map(({ result }) => result);
      const seconds = ((performance.now() - since) / 1000).toFixed(2);
      state.textContent = [`Flown in ${seconds} s.`, landings[0]?.vehicle].filter(Boolean).join(' ');
      show();
    } catch (error) {
      if (!isCancelled(error)) {
        state.textContent = '';
        outcome.replaceChildren(failure(reason(error)));
      }
    } finally {
      fly.disabled = false;
    }
  }

  function show(): void {
    if (view === undefined) view = viewIn(box);
    view?.load(landings, [shade(0), shade(1)]);
    const end = Math.max(...landings.map(({ frames }) => frames.time_s.at(-1) ?? 0));
    time.max = String(end);
    play.disabled = record.disabled = false;
    const names = controllers();
    const value = (landing: Landing, key: string) => landing.row.find(([name]) => name === key)?.[1] ?? '';
    const text = (of: string) => (of === '' ? '–' : Number.isNaN(Number(of)) ? of.replaceAll('_', ' ') : number(Number(of)));
    outcome.replaceChildren(
      table(
        'Outcome',
        ['', ...names.map(label)],
        ROWS.map(([key, words]) => [words, ...landings.map((landing) => text(value(landing, key)))]),
      ),
    );
    for (const plot of plots) plot.destroy();
    charts.replaceChildren();
    plots = figures(landings, names.map(label)).map((plot) => {
      const place = el('div', { class: 'plot' });
      charts.append(place);
      return draw(place, plot, { height: 230, cursor: { sync: { key: 'deck' }, drag: { x: false, y: false } } });
    });
    for (const plot of plots) {
      plot.over.addEventListener('click', () => {
        const at = plot.posToVal(plot.cursor.left ?? 0, 'x');
        seek(at);
      });
    }
    file.textContent = toml(scenario, scenario.first, lab.cards.map((card) => (card.kind === 'thrust' ? 'thrust' : 'dynamic')));
    seek(0);
    if (!still.matches) playback.run();
  }

  function seek(at: number): void {
    time.value = String(at);
    now.textContent = `${Number(time.value).toFixed(2)} s, ${landings[0] ? phaseAt(landings[0], at) : ''}`;
    view?.show(at);
    for (const plot of plots) {
      plot.setCursor({ left: plot.valToPos(at, 'x'), top: 0 }, false);
    }
  }

  async function save(): Promise<void> {
    const request = { task: 'record', sweep: '/in/sweep.toml', landing: scenario.landing, out: '/out' };
    const { written } = await lab.calculator.ask(request, files(scenario.first));
    for (const [name, bytes] of written) download(name, bytes as BlobPart, 'application/octet-stream');
  }

  async function copy(): Promise<void> {
    read();
    history.replaceState(null, '', `#${toHash(scenario)}`);
    try {
      await navigator.clipboard.writeText(location.href);
      state.textContent = 'The link is copied. Cards are not in it.';
    } catch {
      state.textContent = 'The address above is the link. Cards are not in it.';
    }
  }

  function listCards(): void {
    const none = el('li', {}, 'The built-in models fly. Cards of step 2 replace them.');
    const items = lab.cards.map((card) =>
      el(
        'li',
        {},
        `${card.kind === 'thrust' ? 'Thrust' : 'Ground effect'}: ${card.name} `,
        el('button', { type: 'button', onclick: () => lab.remove(card.kind) }, 'Remove'),
      ),
    );
    cards.replaceChildren(...(items.length > 0 ? items : [none]));
  }

  fly.addEventListener('click', () => void start());
  record.addEventListener('click', () => void save());
  share.addEventListener('click', () => void copy());
  addEventListener('hashchange', () => {
    scenario = fromHash(location.hash);
    fill();
  });
  lab.watch(listCards);
  listCards();
  fill();
  const field = (text: string, input: HTMLElement, value?: HTMLElement) =>
    el('label', { class: 'field' }, el('span', {}, text, value ? ' ' : null, value ?? null), input);
  const many = crowd.panel(() => {
    read();
    return controllers().map((name) => ({ name: label(name), files: files(name) }));
  });
  panel.append(
    el(
      'div',
      { class: 'fields' },
      field('Deck', selects.deck),
      ...sliders.map(({ label: text, input, value }) => field(text, input, value)),
      field('Controller', selects.first),
      field('Ghost', selects.second),
      field('Seed', numbers.seed),
      field('Landing', numbers.landing),
    ),
    cards,
    el('div', { class: 'row' }, fly, play, record, share),
    state,
    box,
    el('div', { class: 'scrub' }, time, now),
    el(
      'div',
      { class: 'columns' },
      charts,
      el('div', {}, outcome, many, el('details', {}, el('summary', {}, 'This scenario as a file'), file)),
    ),
  );
  return {
    shown: () => {
      if (landings.length === 0 && !fly.disabled) void start();
    },
  };
}

/** Heights, closing speeds and ground effect of the landings over time. */
function figures(landings: Landing[], names: string[]): Plot[] {
  const of = (pick: (landing: Landing) => number[], suffix = '') =>
    landings.map((landing, k) => ({
      name: `${names[k]}${suffix}`,
      style: 'line' as const,
      x: landing.frames.time_s,
      y: pick(landing),
    }));
  const first = landings[0]!;
  return [
    { title: 'Height above the deck', x: 'Time (s)', y: 'Height (m)', series: of((l) => l.frames.height_m) },
    { title: 'Velocity relative to the deck', x: 'Time (s)', y: 'Velocity (m/s)', series: of((l) => l.frames.velocity_mps) },
    {
      title: 'Ground effect',
      x: 'Time (s)',
      y: 'Force (N)',
      series: [
        ...of((l) => l.frames.ground_effect_n),
        {
          name: `${names[0]}: counted on`,
          style: 'line',
          x: first.frames.time_s,
          y: first.frames.counted_ground_effect_n,
        },
      ],
    },
  ];
}
