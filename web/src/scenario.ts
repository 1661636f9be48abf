// The scenario of the deck: what the controls say, as a file that `touchdown land --space` reads, and as an address.

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
  second: string;
  seed: number;
  landing: number;
}

export const DEFAULT: Scenario = {
  deck: 'sea',
  height_m: 0.4,
  period_s: 6,
  wind_mps: 3,
  // That of the simulator, at which the built-in models were identified.
  strength: 0.5,
  delay_s: 0.01,
  first: 'dynamic+observer',
  second: 'feedback',
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
/** The second controller where one alone is watched. */
export const NOBODY = 'none';

/** Words that a key may have. */
const WORDS: Record<string, string[]> = {
  deck: DECKS.map(([name]) => name),
  first: CONTROLLERS.map(([name]) => name),
  second: [...CONTROLLERS.map(([name]) => name), NOBODY],
};

/** Landings that a scenario has: `landing` is one of them. */
export const LANDINGS = 1000;

/** The whole number from 0 to `most` that is nearest. */
export function whole(value: number, most: number): number {
  return Math.min(Math.max(0, Math.trunc(value)), most);
}

/** The file of a scenario for one of its controllers. Cards stand beside it. */
export function toml(of: Scenario, controller: string, cards: string[]): string {
  const float = (v: number) => (Number.isInteger(v) ? v.toFixed(1) : String(v));
  const deck = {
    still: 'kind = "still"',
    sine: `kind = "sines"\ntones = [{ axis = "heave", amplitude = ${float(of.height_m)}, frequency_hz = ${float(1 / of.period_s)} }]`,
    sea: `kind = "sea"\nspectrum = { shape = "jonswap", significant_height_m = ${float(of.height_m)}, peak_period_s = ${float(of.period_s)} }`,
  }[of.deck];
  const lines = [
    `seed = ${of.seed}`,
    `trials = ${LANDINGS}`,
    cards.length > 0 ? `[cards]\n${cards.map((kind) => `${kind} = "${kind}.toml"`).join('\n')}` : '',
    `[scenario]\nground_effect_strength = ${float(of.strength)}\ncommand_delay_s = ${float(of.delay_s)}`,
    `[scenario.control]\ncontroller = "${controller}"`,
    `[scenario.wind]\nsteady_mps = [${float(of.wind_mps)}, 0.0, 0.0]`,
    `[scenario.deck]\n${deck}`,
  ];
  return lines.filter((line) => line !== '').join('\n') + '\n';
}

/** The scenario as the part of an address after `#`. */
export function toHash(of: Scenario): string {
  return new URLSearchParams(Object.entries(of).map(([key, value]) => [key, String(value)])).toString();
}

/** The scenario of an address; what it lacks, or has wrongly, is the default. */
export function fromHash(hash: string): Scenario {
  const given = new URLSearchParams(hash.replace(/^#/, ''));
  const made = { ...DEFAULT } as Record<string, string | number>;
  for (const [key, standard] of Object.entries(DEFAULT)) {
    const text = given.get(key);
    if (text === null) continue;
    if (typeof standard === 'number') {
      const value = Number(text);
      if (Number.isFinite(value)) made[key] = value;
    } else if (WORDS[key]?.includes(text)) {
      made[key] = text;
    }
  }
  const scenario = made as unknown as Scenario;
  scenario.seed = whole(scenario.seed, Number.MAX_SAFE_INTEGER);
  scenario.landing = whole(scenario.landing, LANDINGS - 1);
  return scenario;
}
