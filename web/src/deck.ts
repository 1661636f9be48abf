// Step 3: landings of two controllers on the same deck.

import type uPlot from 'uplot';
import { download, el, failure, isCancelled, number, reason, refocus, table, warnings } from './dom';
import { checkAll, NumberField } from './field';
import { draw, shade, type Plot } from './plots';
import {
  cardsOf,
  CONTROLLERS,
  DECKS,
  fromHash,
  MODELS,
  NOBODY,
  SCENARIO,
  side,
  SLIDERS,
  toHash,
  toml,
  TYPED,
  type Model,
  type Scenario,
  type Side,
} from './scenario';
import { phaseAt, viewIn, type View, type Landing } from './scene';
import { Legend } from './legend';
import { Playback } from './playback';
import { ownCards, USES } from './cards';
import { Crowd } from './crowd';
import type { CardFile, Lab, Use } from './state';

const LABELS: [keyof typeof SLIDERS, string][] = [
  ['height_m', 'Wave height, or amplitude (m)'],
  ['period_s', 'Period (s)'],
  ['wind_mps', 'Wind (m/s)'],
  ['strength', 'Ground effect (1: the paper’s)'],
  ['delay_s', 'Delay of commands (s)'],
];
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
  let { scenario, faults } = fromHash(location.hash);
  /** Null where the browser cannot draw one: all else is shown. */
  let view: View | null | undefined;
  let landings: Landing[] = [];
  /** The cards of the landings. */
  let flownCards = lab.cards;
  /** What is shown: its address as it was opened and as controls write it, its place in the list, its sides and the files of the first. */
  let flownAs: { hash: string; address: string; landing: number; sides: Side[]; files: Map<string, Blob> } | undefined;
  let running: AbortController | undefined;
  let plots: uPlot[] = [];
  const still = matchMedia('(prefers-reduced-motion: reduce)');
  const options = (of: readonly (readonly [string, string])[]) =>
    of.map(([value, text]) => el('option', { value }, text));
  const selects = {
    deck: el('select', { id: 'deck-motion' }, ...options(DECKS)),
    first: el('select', { id: 'first' }, ...options(CONTROLLERS)),
    first_model: el('select', { id: 'first-model' }, ...options(MODELS)),
    second: el('select', { id: 'second' }, ...options(CONTROLLERS), el('option', { value: NOBODY }, 'Nobody')),
    second_model: el('select', { id: 'second-model' }, ...options(MODELS)),
  };
  const numbers = {
    seed: new NumberField('seed', 'Seed', TYPED.seed),
    landing: new NumberField('landing', 'Landing', TYPED.landing),
  };
  const sliders = LABELS.map(([key, label]) => {
    const { min, max, step } = SLIDERS[key];
    const input = el('input', { id: key, type: 'range', min, max, step });
    const value = el('output', { for: key });
    input.addEventListener('input', () => (value.textContent = input.value));
    return { key, label, input, value };
  });
  const fly = el('button', { type: 'button', id: 'fly', class: 'primary' }, 'Fly');
  const cancel = el('button', { type: 'button', id: 'fly-cancel', hidden: true, onclick: () => running?.abort() }, 'Cancel');
  const play = el('button', { type: 'button', id: 'play', disabled: true }, 'Play');
  const record = el('button', { type: 'button', id: 'mcap', disabled: true }, 'Download MCAP');
  const share = el('button', { type: 'button', id: 'share' }, 'Copy link');
  const time = el('input', { type: 'range', id: 'time', min: 0, max: 1, step: 0.01, value: 0, 'aria-label': 'Time' });
  const now = el('output', { for: 'time' }, '0.00 s');
  const state = el('p', { role: 'status', class: 'state', id: 'deck-state' });
  const problem = el('div', { id: 'deck-problem' });
  const missing = el('div', { id: 'missing-cards' });
  const wrong = el('div', { id: 'link-faults', role: 'status' });
  const box = el('div', { class: 'view' });
  const legend = new Legend();
  const charts = el('div', { class: 'charts' });
  const outcome = el('div', { id: 'outcome' });
  const cards = ownCards(lab, panel);
  const file = el('pre', { tabindex: 0 });
  const crowd = new Crowd(lab);
  const playback = new Playback(play, time, seek);

  function fill(): void {
    for (const [key, select] of Object.entries(selects)) select.value = String(scenario[key as keyof Scenario]);
    for (const { key, input, value } of sliders) {
      input.value = String(scenario[key]);
      value.textContent = input.value;
    }
    numbers.seed.set(scenario.seed);
    numbers.landing.set(scenario.landing);
  }

  function read(): void {
    scenario = {
      ...scenario,
      deck: selects.deck.value as Scenario['deck'],
      first: selects.first.value,
      first_model: selects.first_model.value as Model,
      second: selects.second.value,
      second_model: selects.second_model.value as Model,
      // A field that is wrong is marked, and nothing flies.
      seed: numbers.seed.value() ?? scenario.seed,
      landing: numbers.landing.value() ?? scenario.landing,
    };
    for (const { key, input } of sliders) scenario[key] = Number(input.value);
  }

  /** Files of the scenario for a side: it and the cards that fly. */
  function files(of: Side): Map<string, Blob> {
    const cards = of.cards.map((card): [string, string] => [`${card.use}.toml`, card.toml]);
    const all: [string, string][] = [[SCENARIO, toml(scenario, of)], ...cards];
    return new Map(all.map(([name, content]) => [name, new Blob([content])]));
  }

  const first = () => side(scenario.first, scenario.first_model, lab.cards);
  const sides = () =>
    scenario.second === NOBODY ? [first()] : [first(), side(scenario.second, scenario.second_model, lab.cards)];

  /** A controller in words, with its model where there is a choice. */
  function label({ controller, model }: Side): string {
    const words = CONTROLLERS.find(([value]) => value === controller)?.[1] ?? controller;
    const chosen = lab.cards.length > 0 && model !== 'none';
    return chosen ? `${words} (${model === 'own' ? 'own card' : 'built-in'})` : words;
  }

  /** The address of the scenario, which a link then shows. */
  function address(of = scenario): string {
    const own = lab.cards.map(({ use }) => use).filter((use) => sides().some((each) => each.cards.some((card) => card.use === use)));
    return `#${toHash(of, own)}`;
  }

  /** The same without the number of the landing: what a hundred landings are of. */
  const campaign = () => address({ ...scenario, landing: 0 });

  /** Does work that can be cancelled; its text is shown at the end. */
  async function work(text: string, of: (signal: AbortSignal) => Promise<string>): Promise<void> {
    running?.abort();
    const own = (running = new AbortController());
    problem.replaceChildren();
    const focus = refocus();
    fly.disabled = record.disabled = true;
    cancel.hidden = false;
    state.textContent = text;
    let end = '';
    try {
      end = await of(own.signal);
    } catch (error) {
      if (isCancelled(error)) end = 'Cancelled.';
      else if (running === own) problem.replaceChildren(failure(reason(error)));
    }
    // Other work has begun: the page shows that.
    if (running !== own) return;
    running = undefined;
    state.textContent = end;
    cancel.hidden = true;
    fly.disabled = false;
    record.disabled = landings.length === 0;
    focus();
  }

  /** Flies the scenario of the controls; that of a link keeps its address. Whether the controls make one. */
  async function start(fromLink = false): Promise<boolean> {
    if (!checkAll(Object.values(numbers))) {
      state.textContent = 'Nothing was flown: a field above is marked, and says what it takes.';
      return false;
    }
    read();
    // The address of a link stays, but for values that do not fly.
    const linked = faults.length > 0 ? `#${toHash(scenario, cardsOf(location.hash))}` : location.hash;
    missingCards(fromLink ? cardsOf(location.hash) : []);
    wrong.replaceChildren(...(fromLink ? [warnings('This link has values that cannot fly', faults)] : []).filter((box) => box !== null));
    crowd.keep(campaign());
    playback.stop();
    const before = flownAs;
    const since = performance.now();
    await work('Flying …', async (signal) => {
      const request = { task: 'land', sweep: SCENARIO, landing: scenario.landing };
      const [flown, cards] = [sides(), lab.cards];
      const asked = flown.map((of) => lab.calculator.ask<Landing>(request, files(of), signal));
      const own = { hash: fromLink ? linked : address(), address: address(), landing: scenario.landing, sides: flown, files: files(flown[0]!) };
      landings = (await Promise.all(asked)).map(({ result }) => result);
      flownCards = cards;
      flownAs = own;
      // Each scenario that has flown is a step of the browser's history; the first one is that of the page itself.
      if (own.hash !== location.hash) history[before && !fromLink ? 'pushState' : 'replaceState'](null, '', own.hash);
      const seconds = ((performance.now() - since) / 1000).toFixed(2);
      show(flown);
      file.textContent = toml(scenario, flown[0]!);
      seek(0);
      if (!still.matches) playback.run();
      return [`Flown in ${seconds} s.`, landings[0]?.vehicle].filter(Boolean).join(' ');
    });
    // It was cancelled or it failed, and no other flight has begun.
    if (before && flownAs === before && !running) {
      history.replaceState(null, '', before.hash);
      state.textContent = `${state.textContent} Below is the landing that was flown before.`.trim();
    }
    return true;
  }

  /** Says that a link was made with own cards which are not here. */
  function missingCards(stated: Use[]): void {
    const absent = stated.filter((use) => !lab.card(use)).map((use) => USES[use].toLowerCase());
    const text =
      `This link was made with own cards (${absent.join('; ')}). A link does not hold cards, so built-in models fly here and ` +
      'the landing is another one. To fly the same, add the files of the cards, or identify them in step 2 from the same logs.';
    missing.replaceChildren(...(absent.length > 0 ? [el('div', { class: 'warning', role: 'status' }, text)] : []));
  }

  function show(flown: Side[]): void {
    if (view === undefined) view = viewIn(box);
    const colours = [shade(0), shade(1)];
    const names = flown.map(label);
    view?.load(landings, colours);
    legend.load(landings, colours, names);
    const end = Math.max(...landings.map(({ frames }) => frames.time_s.at(-1) ?? 0));
    time.max = String(end);
    play.disabled = false;
    const value = (landing: Landing, key: string) => landing.row.find(([name]) => name === key)?.[1] ?? '';
    const text = (of: string) => (of === '' ? '–' : Number.isNaN(Number(of)) ? of.replaceAll('_', ' ') : number(Number(of)));
    outcome.replaceChildren(
      table(
        'Outcome',
        ['', ...names],
        ROWS.map(([key, words]) => [words, ...landings.map((landing) => text(value(landing, key)))]),
      ),
    );
    for (const plot of plots) plot.destroy();
    charts.replaceChildren();
    plots = figures(landings, names).map((plot) => {
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
  }

  // Colours follow the page's: the landing is drawn again, and stays where it is in time.
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => {
    if (flownAs === undefined) return;
    show(flownAs.sides);
    seek(Number(time.value));
  });

  function seek(at: number): void {
    time.value = String(at);
    now.textContent = `${Number(time.value).toFixed(2)} s, ${landings[0] ? phaseAt(landings[0], at) : ''}`;
    view?.show(at);
    legend.show(Number(time.value));
    for (const plot of plots) {
      plot.setCursor({ left: plot.valToPos(at, 'x'), top: 0 }, false);
    }
  }

  async function save(): Promise<void> {
    const [before, flown] = [state.textContent ?? '', flownAs];
    if (!flown) return;
    await work('Recording …', async (signal) => {
      const request = { task: 'record', sweep: SCENARIO, landing: flown.landing, out: '/out' };
      const { written } = await lab.calculator.ask(request, flown.files, signal);
      for (const [name, bytes] of written) download(name, bytes as BlobPart, 'application/octet-stream');
      return before;
    });
  }

  async function copy(): Promise<void> {
    if (!flownAs && !checkAll(Object.values(numbers))) return;
    read();
    const hash = flownAs?.hash ?? address();
    history.replaceState(null, '', hash);
    const of = (flownAs?.address ?? hash) === address() ? '' : ' It shows the landing below; what was set since then has not flown.';
    try {
      await navigator.clipboard.writeText(location.href);
      state.textContent = `The link is copied. Cards are not in it.${of}`;
    } catch {
      state.textContent = `The address above is the link. Cards are not in it.${of}`;
    }
  }

  /** An own ground effect needs a card. */
  function offerOwn(): void {
    for (const select of [selects.first_model, selects.second_model]) {
      select.querySelector<HTMLOptionElement>('[value=own]')!.disabled = !lab.cards.some(({ use }) => use !== 'thrust');
    }
  }

  /** An own ground effect flies beside the same controller without it. */
  function receive({ use }: CardFile): void {
    read();
    // A side that flies it already, as that of a link, stays.
    if (use === 'thrust' || sides().some((of) => of.model === 'own' && of.use === use)) return;
    if (use === 'empirical') scenario.first = 'empirical';
    else if (!scenario.first.startsWith('dynamic')) scenario.first = 'dynamic+observer';
    scenario.first_model = 'own';
    scenario.second = scenario.first;
    scenario.second_model = 'none';
    fill();
  }

  fly.addEventListener('click', () => void start());
  record.addEventListener('click', () => void save());
  share.addEventListener('click', () => void copy());
  addEventListener('hashchange', () => {
    ({ scenario, faults } = fromHash(location.hash));
    fill();
    void start(true);
  });
  lab.watch(offerOwn);
  lab.receive(receive);
  offerOwn();
  fill();
  const field = (text: string, input: HTMLElement, value?: HTMLElement) =>
    el('label', { class: 'field', for: input.id }, el('span', {}, text, value ? ' ' : null, value ?? null), input);
  const many = crowd.panel(() => {
    if (!checkAll(Object.values(numbers))) return undefined;
    read();
    // The landing beside the distribution is one of it.
    if (flownAs?.address !== address()) void start();
    return { of: campaign(), sides: sides().map((of) => ({ name: label(of), files: files(of) })) };
  });
  panel.append(
    el(
      'div',
      { class: 'fields' },
      field('Deck', selects.deck),
      ...sliders.map(({ label: text, input, value }) => field(text, input, value)),
      field('Controller', selects.first),
      field('Its ground-effect model', selects.first_model),
      field('Ghost', selects.second),
      field('The ghost’s ground-effect model', selects.second_model),
      numbers.seed.element,
      numbers.landing.element,
    ),
    cards,
    missing,
    wrong,
    el('div', { class: 'row' }, fly, cancel, play, record, share),
    state,
    problem,
    box,
    legend.element,
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
      // Cards that have come or gone since make other landings.
      if ((landings.length === 0 || flownCards !== lab.cards) && !running) void start(landings.length === 0 && location.hash.length > 1);
    },
  };
}

/** Heights, closing speeds and ground effect of the landings over time. */
function figures(landings: Landing[], names: string[]): Plot[] {
  const of = (pick: (landing: Landing) => number[], suffix = '') =>
    landings.map((landing, k) => ({
      name: `${names[k]}${suffix}`,
      // Not by its colour alone.
      style: k === 0 ? ('line' as const) : ('dashed' as const),
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
          style: 'dotted',
          x: first.frames.time_s,
          y: first.frames.counted_ground_effect_n,
        },
      ],
    },
  ];
}
