// Figures: uPlot with the page's colours.

import uPlot from 'uplot';
import 'uplot/dist/uPlot.min.css';
import { el } from './dom';

/** A pair of axes as the calculations return it. */
export interface Plot {
  title: string;
  caption?: string;
  x: string;
  y: string;
  log_y?: boolean;
  series: Series[];
  /** Places on the horizontal axis. */
  marks?: { name: string; x: number }[];
}

export interface Series {
  name: string;
  style: 'line' | 'dashed' | 'dotted' | 'line_points' | 'points' | 'low' | 'high';
  x: (number | null)[];
  y: (number | null)[];
  /** The interval of each point, drawn as a bar. */
  bars?: [number, number][];
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

/** Dashes and gaps of lines, in pixels. */
const DASHES: Partial<Record<Series['style'], number[]>> = { dashed: [7, 4], dotted: [2, 3] };

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
      label: s.name === '' ? plot.y : s.style === 'low' ? `${s.name}, from` : s.style === 'high' ? `${s.name}, to` : s.name,
      stroke,
      width: bound ? 1 : 1.5,
      dash: bound ? [4, 4] : DASHES[s.style],
      spanGaps: true,
      // Lines that end between two pixels are smooth.
      pxAlign: 0,
      paths: s.style === 'points' ? () => null : undefined,
      points: s.style.endsWith('points') ? { show: true, paths: dots(stroke, s.x.length < 100 ? 6 : 4) } : { show: false },
      value: (_: uPlot, v: number | null) => (v == null ? '–' : v.toPrecision(5)),
    };
  });
  const low = plot.series.findIndex((s) => s.style === 'low');
  const ends = plot.series.flatMap((s) => (s.bars ?? []).flat());
  const withBars: uPlot.Range.Function = (_, least, most) => uPlot.rangeNum(Math.min(least, ...ends), Math.max(most, ...ends), 0.1, true);
  // Bars at the ends of the axis are not cut.
  const roomy: uPlot.Range.Function = (_, least, most) => [least - 0.05 * (most - least), most + 0.05 * (most - least)];
  const samples = [undefined, ...plot.series.map((s) => (s.style in DASHES ? s.style : s.style === 'low' || s.style === 'high' ? 'dashed' : 'solid'))];
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
      scales: { x: ends.length > 0 ? { time: false, range: roomy } : { time: false }, y: plot.log_y ? { distr: 3 } : ends.length > 0 ? { range: withBars } : {} },
      axes: [axis(plot.x), { ...axis(plot.y === '1' ? plot.title : plot.y), size: 62 }],
      series: [{ label: plot.x }, ...series],
      bands: low < 0 ? [] : [{ series: [low + 2, low + 1], fill: `${COLOURS[0]}44` }],
      cursor: { drag: { x: true, y: false } },
      // The sample of a line has its dashes.
      legend: { markers: { dash: (_, k) => samples[k] ?? 'solid' } },
      hooks: { draw: [(of) => drawMarks(of, plot.marks ?? []), (of) => drawBars(of, plot.series)] },
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

/** Draws points one by one: thousands of them in one path, as uPlot has them, take a software renderer a minute. */
function dots(colour: string, size: number): uPlot.Series.Points.PathBuilder {
  return (on, k, from, to) => {
    const { ctx, bbox } = on;
    const [xs, ys] = [on.data[0], on.data[k]!];
    ctx.save();
    ctx.beginPath();
    ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
    ctx.clip();
    ctx.fillStyle = colour;
    for (let i = from; i <= to; i++) {
      const y = ys[i];
      if (y == null) continue;
      ctx.beginPath();
      ctx.arc(on.valToPos(xs[i]!, 'x', true), on.valToPos(y, 'y', true), (size / 2) * devicePixelRatio, 0, 2 * Math.PI);
      ctx.fill();
    }
    ctx.restore();
    // Nothing is left for uPlot to draw.
    return { stroke: null, fill: null, clip: new Path2D(), flags: 0 };
  };
}

/** Dashed lines at places on the horizontal axis, with their names. */
function drawMarks(on: uPlot, marks: { name: string; x: number }[]): void {
  const { ctx, bbox } = on;
  ctx.save();
  ctx.strokeStyle = ctx.fillStyle = colour('--text');
  ctx.textAlign = 'left';
  ctx.setLineDash([6, 4]);
  for (const { name, x } of marks) {
    const at = Math.round(on.valToPos(x, 'x', true));
    if (at < bbox.left || at > bbox.left + bbox.width) continue;
    ctx.beginPath();
    ctx.moveTo(at, bbox.top);
    ctx.lineTo(at, bbox.top + bbox.height);
    ctx.stroke();
    ctx.fillText(name, at + 4, bbox.top + 12 * devicePixelRatio);
  }
  ctx.restore();
}

/** Intervals of points, as bars with ends. */
function drawBars(on: uPlot, all: Series[]): void {
  const { ctx } = on;
  const half = 4 * devicePixelRatio;
  ctx.save();
  ctx.lineWidth = 1.5 * devicePixelRatio;
  all.forEach(({ x, bars }, k) => {
    ctx.strokeStyle = shade(k);
    ctx.beginPath();
    (bars ?? []).forEach((bar, i) => {
      const at = on.valToPos(x[i]!, 'x', true);
      const [low, high] = bar.map((y) => on.valToPos(y, 'y', true)) as [number, number];
      ctx.moveTo(at, low);
      ctx.lineTo(at, high);
      for (const end of [low, high]) {
        ctx.moveTo(at - half, end);
        ctx.lineTo(at + half, end);
      }
    });
    ctx.stroke();
  });
  ctx.restore();
}

/** Draws a figure in a box of its own, once the box is in the page; its caption stands below. */
export function figure(plot: Plot): HTMLElement {
  const box = document.createElement('div');
  box.className = 'plot';
  box.setAttribute('role', 'img');
  box.setAttribute('aria-label', `${plot.title}: ${plot.y} over ${plot.x}`);
  // A box in closed details has no width: it is drawn when it gets one.
  new ResizeObserver((_, observer) => {
    if (box.clientWidth === 0) return;
    observer.disconnect();
    draw(box, plot);
  }).observe(box);
  return plot.caption ? el('figure', {}, box, el('figcaption', {}, plot.caption)) : box;
}

matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => {
  for (const plot of drawn) plot.redraw();
});
