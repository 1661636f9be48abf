// Figures: uPlot with the page's colours.

import uPlot from 'uplot';
import 'uplot/dist/uPlot.min.css';

/** A figure as the calculations return it. */
export interface Plot {
  title: string;
  x: string;
  y: string;
  series: Series[];
}

export interface Series {
  name: string;
  style: 'line' | 'points' | 'low' | 'high';
  x: (number | null)[];
  y: (number | null)[];
}

/** Okabe and Ito's colours, which people with colour-blindness tell apart. */
export const COLOURS = ['#0072b2', '#d55e00', '#009e73', '#cc79a7', '#e69f00', '#56b4e9'];

/** The colour of a series: on a dark page the two blues of the list change places, because the first is too dark there. */
export function shade(k: number): string {
  const dark = matchMedia('(prefers-color-scheme: dark)').matches;
  const at = k % COLOURS.length;
  const place = dark && (at === 0 || at === 5) ? 5 - at : at;
  return COLOURS[place]!;
}

const drawn = new Set<uPlot>();

function colour(name: string): string {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}

/** Draws a figure into a box, and again when the box changes its width or the page its colours. */
export function draw(into: HTMLElement, plot: Plot, options: Partial<uPlot.Options> = {}): uPlot {
  const tables = plot.series.map((s) => [s.x, s.y] as uPlot.AlignedData);
  const data = tables.length === 0 ? [[]] : uPlot.join(tables);
  let own = 0;
  const series: uPlot.Series[] = plot.series.map((s) => {
    const bound = s.style === 'low' || s.style === 'high';
    const stroke = bound ? shade(0) : shade(own++);
    return {
      label: s.style === 'low' ? `${s.name}, from` : s.style === 'high' ? `${s.name}, to` : s.name,
      stroke,
      width: bound ? 1 : 1.5,
      dash: bound ? [4, 4] : undefined,
      spanGaps: true,
      paths: s.style === 'points' ? () => null : undefined,
      points: s.style === 'points' ? { show: true, size: 4, fill: stroke } : { show: false },
      value: (_: uPlot, v: number | null) => (v == null ? '–' : v.toPrecision(5)),
    };
  });
  const low = plot.series.findIndex((s) => s.style === 'low');
  const axis = (label: string): uPlot.Axis => ({
    label,
    labelSize: 22,
    // uPlot's own numbers have three decimals: a small residual would read -0.
    values: (_, ticks) => ticks.map((tick) => (tick == null ? '' : String(Number(tick.toPrecision(6))))),
    stroke: () => colour('--text'),
    grid: { stroke: () => colour('--line'), width: 1 },
    ticks: { stroke: () => colour('--line'), width: 1 },
  });
  const made = new uPlot(
    {
      title: plot.title,
      width: Math.max(into.clientWidth, 260),
      height: 260,
      scales: { x: { time: false } },
      axes: [axis(plot.x), { ...axis(plot.y === '1' ? plot.title : plot.y), size: 62 }],
      series: [{ label: plot.x }, ...series],
      bands: low < 0 ? [] : [{ series: [low + 2, low + 1], fill: `${COLOURS[0]}44` }],
      cursor: { drag: { x: true, y: false } },
      ...options,
    },
    data as uPlot.AlignedData,
    into,
  );
  drawn.add(made);
  const resized = new ResizeObserver(() => {
    if (!into.isConnected) {
      resized.disconnect();
      drawn.delete(made);
    } else if (into.clientWidth > 0 && into.clientWidth !== made.width) {
      made.setSize({ width: into.clientWidth, height: made.height });
    }
  });
  resized.observe(into);
  return made;
}

/** Draws a figure in a box of its own, once the box is in the page. */
export function figure(plot: Plot): HTMLElement {
  const box = document.createElement('div');
  box.className = 'plot';
  box.setAttribute('role', 'img');
  box.setAttribute('aria-label', `${plot.title}: ${plot.y} over ${plot.x}`);
  requestAnimationFrame(() => draw(box, plot));
  return box;
}

matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => {
  for (const plot of drawn) plot.redraw();
});
