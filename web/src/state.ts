// What the three steps share: the logs, the cards, and the calculations.

import type { Calculator } from './calculator';

/** What a card is for: the thrust, eq. (2) of the empirical law, or the ground effect of `dynamic` and `dynamic+observer`. */
export type Use = 'thrust' | 'empirical' | 'dynamic';

/** Numbers of a vehicle that a card states. */
export interface Vehicle {
  mass_kg?: number | null;
  rotor_radius_m?: number | null;
  arm_m?: number | null;
  rotors?: number | null;
}

/** What a card says of itself. */
export interface CardText {
  name: string;
  kind: 'thrust' | 'ground_effect';
  form: string;
  vehicle: Vehicle;
}

/** What a card is for. */
export function useOf({ kind, form }: CardText): Use {
  if (kind === 'thrust') return 'thrust';
  return form === 'empirical' ? 'empirical' : 'dynamic';
}

/** A card of the person's vehicle, for the deck. */
export interface CardFile {
  use: Use;
  name: string;
  vehicle: Vehicle;
  toml: string;
}

export interface LogFile {
  name: string;
  content: Blob;
}

export class Lab {
  logs: LogFile[] = [];
  /** The text of the map that all logs are read with; empty for the built-in map, or for none. */
  map = '';
  cards: CardFile[] = [];
  private readonly listeners = new Set<() => void>();
  private readonly receivers = new Set<(card: CardFile) => void>();

  constructor(readonly calculator: Calculator) {}

  /** Calls back when logs or cards have changed. */
  watch(listener: () => void): void {
    this.listeners.add(listener);
  }

  changed(): void {
    for (const listener of this.listeners) listener();
  }

  /** Paths of the logs in the folder that the calculations see, with their content. They are the names as dropped, so that errors have them. */
  files(logs = this.logs): { paths: string[]; files: Map<string, Blob> } {
    const files = new Map<string, Blob>();
    const paths = logs.map((log, k) => {
      // Two logs may have the same name.
      const path = logs.findIndex((other) => other.name === log.name) === k ? log.name : `${k + 1}/${log.name}`;
      files.set(path, log.content);
      return path;
    });
    return { paths, files };
  }

  card(use: Use): CardFile | undefined {
    return this.cards.find((card) => card.use === use);
  }

  put(card: CardFile): void {
    this.cards = [...this.cards.filter((old) => old.use !== card.use), card];
    for (const listener of this.receivers) listener(card);
    this.changed();
  }

  /** Calls back with a card that is put on the deck. */
  receive(listener: (card: CardFile) => void): void {
    this.receivers.add(listener);
  }

  remove(use: Use): void {
    this.cards = this.cards.filter((card) => card.use !== use);
    this.changed();
  }
}
