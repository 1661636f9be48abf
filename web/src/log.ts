// Step 1: what is in a log, and the map that makes channels of it.

import { digits, download, el, failure, isCancelled, number, reason, table, warnings } from './dom';
import { figure, type Plot } from './plots';
import type { Lab, LogFile } from './state';

interface Column {
  name: string;
  unit: string | null;
  count: number;
  gaps: number;
  min: number | null;
  median: number | null;
  max: number | null;
  rate_hz: number | null;
}

interface Inspection {
  rows: number;
  time: { column: string; duration_s: number } | null;
  columns: Column[];
  warnings: string[];
}

interface Topic {
  key: string;
  messages: number;
  rate_hz: number | null;
  gaps: number;
  fields: unknown[];
}

interface Inspected {
  table: Inspection | null;
  topics: { format: string; topics: Topic[]; duration_s: number } | null;
  recommended_map: string | null;
  suggested_map: string | null;
  suggested_map_lacks: string | null;
  channels: Inspection | null;
  preview: Plot[];
  findings: { rows_read: number; rows_used: number; warnings: string[] };
}

const EXAMPLES = [
  ['rig', 'Example: a thrust rig', 'Throttle and thrust of the virtual rig'],
  ['flights', 'Example: four flights', 'Simulated landings, as PX4 logs them'],
] as const;

/** Time that typing must rest before a map is tried, ms. */
const REST_MS = 500;

export function logStep(panel: HTMLElement, lab: Lab): void {
  const input = el('input', { type: 'file', multiple: true, id: 'files', class: 'hidden-input' });
  const zone = el(
    'label',
    { for: 'files', class: 'drop' },
    el('strong', {}, 'Drop flight logs or tables here, or press to choose'),
    el('span', {}, 'ULog, DataFlash .bin, MCAP, ROS bag, CSV, Parquet. Nothing is uploaded.'),
  );
  const state = el('p', { role: 'status', class: 'state' });
  const cancel = el('button', { type: 'button', id: 'log-cancel', hidden: true, onclick: () => running.abort() }, 'Cancel');
  const keep = el('button', { type: 'button', id: 'save-logs', hidden: true, onclick: saveLogs }, 'Download the example');
  const choice = el('select', { id: 'which-log', 'aria-label': 'Log to show' });
  const map = el('textarea', { id: 'map', rows: 10, spellcheck: 'false' });
  const mapState = el('p', { role: 'status', class: 'state' });
  const editor = el(
    'details',
    { id: 'map-editor' },
    el('summary', {}, 'Map: how columns become channels'),
    el(
      'p',
      {},
      'Each channel is an expression over columns. The map goes to all logs; an empty one means the built-in map, or columns that are channels already.',
    ),
    el('label', { for: 'map' }, 'Map (TOML)'),
    map,
    mapState,
  );
  const shown = el('div', { id: 'inspection' });
  let running = new AbortController();

  /** Does work that can be cancelled; other work ends it. */
  async function work(text: string, of: (signal: AbortSignal) => Promise<void>, failed: (error: unknown) => void): Promise<void> {
    running.abort();
    const own = (running = new AbortController());
    state.textContent = text;
    cancel.hidden = false;
    try {
      await of(own.signal);
    } catch (error) {
      if (running === own) {
        state.textContent = isCancelled(error) ? 'Cancelled.' : '';
        if (!isCancelled(error)) failed(error);
      }
    }
    if (running === own) cancel.hidden = true;
  }

  async function show(): Promise<void> {
    const log = lab.logs[choice.selectedIndex];
    if (!log) return;
    const { paths, files } = lab.files([log]);
    const request = { task: 'inspect', log: paths[0], map: lab.map === '' ? null : lab.map };
    const read = async (signal: AbortSignal) => {
      const { result } = await lab.calculator.ask<Inspected>(request, files, signal);
      state.textContent = summary(log, result);
      mapState.textContent = lab.map === '' ? '' : 'The map fits this log.';
      shown.replaceChildren(...content(result, lab.map === '' ? offer(result) : null));
    };
    await work(`Reading ${log.name} …`, read, (error) => {
      // Channels of the map before are none of this one.
      shown.replaceChildren(failure(reason(error)));
      mapState.textContent = lab.map === '' ? '' : 'No channels by this map. The reason is below.';
    });
  }

  /** A button that puts the map of a log into the editor: the built-in one that fits, or one to start from. */
  function offer({ suggested_map: suggested, suggested_map_lacks: lacks, recommended_map: builtIn, channels }: Inspected): HTMLElement | null {
    if (!suggested) return null;
    const usable = channels ? 'Edit a map of these columns' : 'Use the suggested map';
    const text = builtIn ? `Edit the built-in map ${builtIn}` : lacks ? 'Complete the suggested map' : usable;
    const take = () => {
      editor.open = true;
      map.value = suggested;
      if (!lacks) return use();
      lab.map = suggested;
      lab.changed();
      mapState.textContent = `This map is not complete: ${lacks}`;
      const at = suggested.indexOf('# time_s');
      map.focus();
      if (at >= 0) map.setSelectionRange(at, suggested.indexOf('\n', at));
    };
    return el('button', { type: 'button', id: 'use-map', onclick: take }, text);
  }

  /** Takes the map of the editor. */
  function use(): void {
    lab.map = map.value.trim() === '' ? '' : map.value;
    lab.changed();
    void show();
  }

  function saveLogs(): void {
    for (const { name, content } of lab.logs) download(name, content, 'application/octet-stream');
  }

  function add(logs: LogFile[], isExample = false): void {
    lab.logs = logs;
    lab.map = map.value = '';
    mapState.textContent = '';
    keep.hidden = !isExample;
    choice.replaceChildren(...logs.map((log) => el('option', {}, log.name)));
    choice.hidden = logs.length < 2;
    shown.replaceChildren();
    lab.changed();
    void show();
  }

  const examples = EXAMPLES.map(([name, label, title]) =>
    el('button', { type: 'button', title, id: `example-${name}`, onclick: () => void example(name) }, label),
  );

  async function example(name: string): Promise<void> {
    const simulate = async (signal: AbortSignal) => {
      const { written } = await lab.calculator.ask({ task: 'example', name, out: '/out' }, new Map(), signal);
      add([...written].map(([file, bytes]) => ({ name: file, content: new Blob([bytes as BlobPart]) })), true);
    };
    await work('Simulating …', simulate, (error) => shown.replaceChildren(failure(reason(error))));
  }

  let rest: ReturnType<typeof setTimeout> | undefined;
  map.addEventListener('input', () => {
    clearTimeout(rest);
    rest = setTimeout(use, REST_MS);
  });
  // Who leaves the editor has ended typing: step 2 must not begin with the map before.
  map.addEventListener('change', () => {
    clearTimeout(rest);
    if (map.value !== lab.map) use();
  });
  choice.addEventListener('change', () => void show());
  const taken = (files: FileList | undefined | null) => {
    if (files && files.length > 0) add([...files].map((content) => ({ name: content.name, content })));
  };
  input.addEventListener('change', () => {
    taken(input.files);
    // The same file may be chosen again.
    input.value = '';
  });
  for (const [name, over] of [['dragover', true], ['dragleave', false], ['drop', false]] as const) {
    zone.addEventListener(name, (event) => {
      event.preventDefault();
      zone.classList.toggle('over', over);
    });
  }
  // A file that misses the zone is meant for it.
  panel.addEventListener('drop', (event) => taken(event.dataTransfer?.files));
  choice.hidden = true;
  panel.append(input, zone, el('div', { class: 'row' }, ...examples, keep), el('div', { class: 'row' }, state, cancel), choice, editor, shown);
}

function summary(log: LogFile, of: Inspected): string {
  const { size: bytes } = log.content;
  const size = bytes < 1e6 ? `${(bytes / 1e3).toFixed(1)} kB` : `${(bytes / 1e6).toFixed(1)} MB`;
  if (of.topics) {
    const { format, topics, duration_s } = of.topics;
    const map = of.recommended_map ? `; the built-in map ${of.recommended_map} fits` : '';
    return `${log.name}: ${size}, ${format}, ${topics.length} topics, ${digits(duration_s)} s${map}`;
  }
  const time = of.table?.time ? `, ${digits(of.table.time.duration_s)} s by ${of.table.time.column}` : '';
  return `${log.name}: ${size}, ${of.table?.rows ?? 0} rows${time}`;
}

function content(of: Inspected, offer: HTMLElement | null): (Node | string)[] {
  const all = [...(of.table?.warnings ?? []), ...(of.channels?.warnings ?? []), ...of.findings.warnings];
  const parts: (Node | null)[] = [warnings('Of this log', all), offer];
  if (of.channels) parts.push(columns('Channels', of.channels));
  if (of.preview.length > 0) {
    const box = el('div');
    const choose = el('select', { id: 'channel' }, ...of.preview.map((plot) => el('option', {}, plot.title)));
    const redraw = () => box.replaceChildren(figure(of.preview[choose.selectedIndex]!));
    choose.addEventListener('change', redraw);
    redraw();
    parts.push(el('label', { for: 'channel' }, 'Channel'), choose, box);
  }
  if (of.table && !of.channels) parts.push(columns('Columns', of.table));
  if (of.topics) {
    const rows = of.topics.topics.map((t) => [
      t.key,
      String(t.messages),
      number(t.rate_hz),
      String(t.gaps),
      String(t.fields.length),
    ]);
    parts.push(
      el(
        'details',
        {},
        el('summary', {}, `Topics (${rows.length})`),
        table('Topics of the log', ['Topic', 'Messages', 'Rate (Hz)', 'Gaps', 'Fields'], rows),
      ),
    );
  }
  return parts.filter((part): part is Node => part !== null);
}

function columns(title: string, of: Inspection): HTMLElement {
  const rows = of.columns.map((c) => [
    c.name,
    c.unit ?? '',
    String(c.count),
    String(c.gaps),
    number(c.rate_hz),
    number(c.min),
    number(c.median),
    number(c.max),
  ]);
  return table(title, ['Name', 'Unit', 'Values', 'Gaps', 'Rate (Hz)', 'Least', 'Median', 'Greatest'], rows);
}
