// Landings to watch in a report: each `figure.scene` has its data, and gets a view, a button and a bar for the time.

import { Legend } from './legend';
import { Playback } from './playback';
import { phaseAt, viewIn, type Watched } from './scene';

/** Colours of the first vehicle and of its ghost, which colour-blind readers tell apart (Okabe and Ito). */
const COLOURS = ['#0072b2', '#d55e00'];

/** A column of 16-bit steps, a list of columns that stand for a list of rows, or names by their places in a list. */
type Packed =
  | { low: number; step: number; packed: string }
  | { columns: number[][] }
  | { names: string[]; of: number[] };

function isPacked(value: unknown): value is Packed {
  return typeof value === 'object' && value !== null && ('packed' in value || 'columns' in value || 'names' in value);
}

/** What was packed, whose parts are unpacked by now. */
function unpack(value: Packed): unknown[] {
  if ('columns' in value) return value.columns[0]!.map((_, row) => value.columns.map((column) => column[row]));
  if ('names' in value) return value.of.map((place) => value.names[Math.round(place)]);
  const bytes = Uint8Array.from(atob(value.packed), (c) => c.charCodeAt(0));
  return Array.from(new Uint16Array(bytes.buffer), (code) => (code === 65535 ? null : value.low + code * value.step));
}

function read(text: string): { landings: Watched[] } {
  return JSON.parse(text, (_, value: unknown) => (isPacked(value) ? unpack(value) : value));
}

function begin(figure: HTMLElement): void {
  const find = <E extends Element>(of: string) => figure.querySelector<E>(of)!;
  const { landings } = read(find('script').textContent!);
  const box = find<HTMLElement>('.view');
  const [time, now, play] = [find<HTMLInputElement>('input'), find('output'), find<HTMLButtonElement>('button')];
  const first = landings[0];
  if (!first) return;
  const view = viewIn(box, false);
  if (!view) return;
  view.load(landings, COLOURS);
  const legend = new Legend();
  legend.load(landings, COLOURS, [...figure.querySelectorAll('.key')].map((key) => key.textContent ?? ''));
  box.after(legend.element);
  time.min = String(first.frames.time_s[0] ?? 0);
  time.max = String(Math.max(...landings.map(({ frames }) => frames.time_s.at(-1) ?? 0)));
  const seek = (at: number) => {
    time.value = String(at);
    now.textContent = `${at.toFixed(2)} s, ${phaseAt(first, at)}`;
    time.setAttribute('aria-valuetext', now.textContent);
    view.show(at);
    legend.show(at);
  };
  const playback = new Playback(play, time, seek);
  figure.classList.add('drawn');
  play.disabled = time.disabled = false;
  seek(Number(time.min));
  const still = matchMedia('(prefers-reduced-motion: reduce)').matches;
  // It plays while it is looked at, once.
  new IntersectionObserver((entries, observer) => {
    if (entries.some(({ isIntersecting }) => isIntersecting)) {
      if (!still) playback.run();
      observer.disconnect();
    }
  }, { threshold: 0.6 }).observe(box);
}

// Views are drawn when they come near the window: reports open at once.
const watch = new IntersectionObserver((entries) => {
  for (const { isIntersecting, target } of entries) {
    if (!isIntersecting) continue;
    watch.unobserve(target);
    begin(target as HTMLElement);
  }
}, { rootMargin: '400px' });
for (const figure of document.querySelectorAll<HTMLElement>('figure.scene')) watch.observe(figure);
