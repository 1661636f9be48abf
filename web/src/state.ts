// What the three steps share: the logs, the cards, and the calculations.

import type { Calculator } from './calculator';

/** A card of the person's vehicle, for the deck. */
export interface CardFile {
  kind: 'thrust' | 'ground_effect';
  name: string;
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

  constructor(readonly calculator: Calculator) {}

  /** Calls back when logs or cards have changed. */
  watch(listener: () => void): void {
    this.listeners.add(listener);
  }

  changed(): void {
    for (const listener of this.listeners) listener();
  }

  /** Paths of the logs in the folder that the calculations see, with their content. */
  files(logs = this.logs): { paths: string[]; files: Map<string, Blob> } {
    const files = new Map<string, Blob>();
    const paths = logs.map((log, k) => {
      // Two logs may have the same name.
      const folder = logs.findIndex((other) => other.name === log.name) === k ? 'in' : `in/${k}`;
      files.set(`${folder}/${log.name}`, log.content);
      return `/${folder}/${log.name}`;
    });
    return { paths, files };
  }

  card(kind: CardFile['kind']): CardFile | undefined {
    return this.cards.find((card) => card.kind === kind);
  }

  put(card: CardFile): void {
    this.cards = [...this.cards.filter((old) => old.kind !== card.kind), card];
    this.changed();
  }

  remove(kind: CardFile['kind']): void {
    this.cards = this.cards.filter((card) => card.kind !== kind);
    this.changed();
  }
}
