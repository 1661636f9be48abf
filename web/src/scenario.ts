// The scenario of the deck: what the controls say, as a file that `touchdown land --space` reads, and as an address.

import { expected, numberOf, type NumberLimits } from './number';
import type { CardFile, Use, Vehicle } from './state';

export interface Scenario {
  deck: 'still' | 'sine' | 'sea';
  /** Amplitude of the sine, or significant height of the sea (m). */
  height_m: number;
  /** Period of the sine, or peak period of the sea (s). */
  period_s: number;
  wind_mps: number;
  /** Ground effect over that of the paper. */
  strength: number;
  /** Delay of commands (s). */
  delay_s: number;
  first: string;
  first_model: Model;
  second: string;
  second_model: Model;
  seed: number;
  landing: number;
}

/** Which ground effect a controller counts on. */
export type Model = 'own' | 'built_in' | 'none';

export const DEFAULT: Scenario = {
  deck: 'sea',
  height_m: 0.4,
  period_s: 6,
  wind_mps: 3,
  // That of the simulator, at which the built-in models were identified.
  strength: 0.5,
  delay_s: 0.01,
  first: 'dynamic+observer',
  first_model: 'built_in',
  second: 'feedback',
  second_model: 'built_in',
  seed: 1,
  landing: 0,
};

/** Motions of the deck, with their words. */
export const DECKS = [['sea', 'Work boat in a sea'], ['sine', 'Heave, a sine'], ['still', 'Still']] as const;
/** Controllers, with their words. */
export const CONTROLLERS = [
  ['dynamic+observer', 'Model and observer'],
  ['dynamic', 'Model'],
  ['empirical', 'Empirical law'],
  ['observer', 'Observer, no model'],
  ['feedback', 'Feedback, no model'],
] as const;
/** Ground effects that a controller can count on, with their words. */
export const MODELS = [['own', 'Own card'], ['built_in', 'Built-in'], ['none', 'None']] as const;
/** The card that a controller flies by, and the same controller without its model. */
const WITH_MODEL: Record<string, { use: Use; without: string }> = {
  'dynamic+observer': { use: 'dynamic', without: 'observer' },
  dynamic: { use: 'dynamic', without: 'feedback' },
  empirical: { use: 'empirical', without: 'feedback' },
};
/** The second controller where one alone is watched. */
export const NOBODY = 'none';

/** Words that a key may have. */
const WORDS: Record<string, string[]> = {
  deck: DECKS.map(([name]) => name),
  first: CONTROLLERS.map(([name]) => name),
  second: [...CONTROLLERS.map(([name]) => name), NOBODY],
  first_model: MODELS.map(([name]) => name),
  second_model: MODELS.map(([name]) => name),
};

const USES: Use[] = ['thrust', 'dynamic', 'empirical'];

/** Landings that a scenario has: `landing` is one of them. */
export const LANDINGS = 1000;

/** Numbers that are set by sliders: what they take, and the step from one to the next. */
export const SLIDERS = {
  height_m: { min: 0.05, max: 1.5, step: 0.05, example: '0.4' },
  period_s: { min: 2, max: 15, step: 0.5, example: '6' },
  wind_mps: { min: 0, max: 12, step: 0.5, example: '3' },
  strength: { min: 0, max: 2, step: 0.05, example: '0.5' },
  delay_s: { min: 0, max: 0.1, step: 0.005, example: '0.01' },
};
/** Numbers that are typed. */
export const TYPED: Record<'seed' | 'landing', NumberLimits> = {
  seed: { min: 0, max: Number.MAX_SAFE_INTEGER, whole: true, example: '1' },
  landing: { min: 0, max: LANDINGS - 1, whole: true, example: '0' },
};
/** Faults of a link that are shown, and characters of what it has. */
const MOST_FAULTS = 12;
const MOST_CHARACTERS = 40;

/** One of the two controllers as it flies. */
export interface Side {
  controller: string;
  /** The ground effect that it counts on, and the card of such a model. */
  model: Model;
  use: Use | undefined;
  /** Own cards of its file. */
  cards: CardFile[];
  /** What own cards that are not in its file, or size no vehicle there, state of the vehicle. */
  vehicle: Vehicle;
}

const VEHICLE = ['mass_kg', 'rotor_radius_m', 'arm_m', 'rotors'] as const;

/** A controller with its choice of model, as it flies with the own cards that are there. All sides fly the same vehicle. */
export function side(chosen: string, choice: Model, own: CardFile[]): Side {
  const controller = choice === 'none' ? (WITH_MODEL[chosen]?.without ?? chosen) : chosen;
  const use = WITH_MODEL[controller]?.use;
  const model = use === undefined ? 'none' : choice === 'own' && own.some((card) => card.use === use) ? 'own' : 'built_in';
  const cards = choice === 'built_in' ? own.filter((card) => card.use === 'thrust') : own;
  const sizing = cards.filter((card) => card.use !== 'empirical');
  const vehicle: Vehicle = {};
  for (const key of VEHICLE) {
    if (sizing.some((card) => card.vehicle[key] != null)) continue;
    const value = own.find((card) => card.vehicle[key] != null)?.vehicle[key];
    if (value != null) vehicle[key] = value;
  }
  return { controller, model, use, cards, vehicle };
}

/** The name of a scenario's file in errors. */
export const SCENARIO = 'scenario.toml';

/** The file of a scenario for one of its controllers. Cards stand beside it. */
export function toml(of: Scenario, { controller, cards, vehicle }: Side): string {
  const float = (v: number) => (Number.isInteger(v) ? v.toFixed(1) : String(v));
  const deck = {
    still: 'kind = "still"',
    sine: `kind = "sines"\ntones = [{ axis = "heave", amplitude = ${float(of.height_m)}, frequency_hz = ${float(1 / of.period_s)} }]`,
    sea: `kind = "sea"\nspectrum = { shape = "jonswap", significant_height_m = ${float(of.height_m)}, peak_period_s = ${float(of.period_s)} }`,
  }[of.deck];
  const stated = Object.entries(vehicle).map(([key, value]) => `${key} = ${key === 'rotors' ? value : float(Number(value))}`);
  const lines = [
    `seed = ${of.seed}`,
    `trials = ${LANDINGS}`,
    cards.length > 0 ? `[cards]\n${cards.map(({ use }) => `${use} = "${use}.toml"`).join('\n')}` : '',
    stated.length > 0 ? `[vehicle]\n${stated.join('\n')}` : '',
    `[scenario]\nground_effect_strength = ${float(of.strength)}\ncommand_delay_s = ${float(of.delay_s)}`,
    `[scenario.control]\ncontroller = "${controller}"`,
    `[scenario.wind]\nsteady_mps = [${float(of.wind_mps)}, 0.0, 0.0]`,
    `[scenario.deck]\n${deck}`,
  ];
  return lines.filter((line) => line !== '').join('\n') + '\n';
}

/** The scenario as the part of an address after `#`, with what own cards it flies: the address does not hold the cards. */
export function toHash(of: Scenario, own: Use[]): string {
  const parts = Object.entries(of).map(([key, value]): [string, string] => [key, String(value)]);
  if (own.length > 0) parts.push(['cards', own.join(' ')]);
  return new URLSearchParams(parts).toString();
}

/** The own cards that the landings of an address were flown with. */
export function cardsOf(hash: string): Use[] {
  const given = (new URLSearchParams(hash.replace(/^#/, '')).get('cards') ?? '').split(' ');
  return USES.filter((use) => given.includes(use));
}

/** The scenario of an address. What it lacks is the default; what it has wrongly flies as something near, and is a fault in words. */
export function fromHash(hash: string): { scenario: Scenario; faults: string[] } {
  const scenario = { ...DEFAULT } as unknown as Record<string, string | number>;
  const faults: string[] = [];
  for (const [key, text] of new URLSearchParams(hash.replace(/^#/, ''))) {
    if (key === 'cards') continue;
    const taken = valueOf(key, text);
    if (typeof taken === 'object') {
      faults.push(`${short(key)}: ${taken.expected}; found “${short(text)}”`);
      if (taken.flies === undefined) continue;
      faults[faults.length - 1] += `. ${taken.flies} flies in its place`;
      scenario[key] = taken.flies;
    } else {
      scenario[key] = taken;
    }
  }
  const more = faults.length - MOST_FAULTS;
  return {
    scenario: scenario as unknown as Scenario,
    faults: more > 0 ? [...faults.slice(0, MOST_FAULTS), `${more} more of this kind`] : faults,
  };
}

const short = (text: string) => (text.length > MOST_CHARACTERS ? `${text.slice(0, MOST_CHARACTERS)}…` : text);

/** The value of a part of an address; or what was expected, and what flies in its place where the part is one. */
function valueOf(key: string, text: string): string | number | { expected: string; flies?: string | number } {
  // Names that every object has, such as `constructor`, are none of a scenario.
  if (Object.hasOwn(WORDS, key)) {
    const words = WORDS[key]!;
    return words.includes(text) ? text : { expected: `expected one of ${words.join(', ')}`, flies: DEFAULT[key as keyof Scenario] };
  }
  if (Object.hasOwn(TYPED, key)) {
    const limits = TYPED[key as keyof typeof TYPED];
    const value = numberOf(text, limits);
    return value ?? { expected: expected(limits), flies: Math.trunc(nearest(key, text, limits)) };
  }
  if (Object.hasOwn(SLIDERS, key)) {
    const limits = SLIDERS[key as keyof typeof SLIDERS];
    const near = nearest(key, text, limits);
    // A slider has steps, and what is set by it has few digits.
    const steps = Math.round((near - limits.min) / limits.step);
    const value = Number((limits.min + steps * limits.step).toPrecision(9));
    return numberOf(text, limits) === value ? value : { expected: `${expected(limits)}, in steps of ${limits.step}`, flies: value };
  }
  return { expected: 'expected a value of a scenario' };
}

/** The number within the limits that is nearest to a text; the default for a text that is no number. */
function nearest(key: string, text: string, { min, max }: { min: number; max: number }): number {
  const value = text.trim() === '' ? Number.NaN : Number(text);
  return Number.isNaN(value) ? Number(DEFAULT[key as keyof Scenario]) : Math.min(Math.max(value, min), max);
}
