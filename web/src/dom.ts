// Small helpers for the page's elements. Texts from files only ever become text nodes.

type Child = Node | string | null | undefined;
type Attributes = Record<string, string | number | boolean | ((event: Event) => void)>;

/** An element with attributes, event listeners (`onclick` and so on) and children. */
export function el<K extends keyof HTMLElementTagNameMap>(
  name: K,
  attributes: Attributes = {},
  ...children: Child[]
): HTMLElementTagNameMap[K] {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (typeof value === 'function') made.addEventListener(key.slice(2), value);
    else if (value === true) made.setAttribute(key, '');
    else if (value !== false) made.setAttribute(key, String(value));
  }
  made.append(...children.filter((child): child is Node | string => child != null));
  return made;
}

/** A table in a box that scrolls sideways; numbers at the right. */
export function table(caption: string, header: string[], rows: Child[][]): HTMLElement {
  const isNumber = header.map((_, column) =>
    rows.every(({ [column]: child }) =>
      typeof child === 'string' ? /^[-−≤–\d.e+ ]*$/.test(child) : child == null || child instanceof HTMLSpanElement,
    ),
  );
  const cell = (tag: 'td' | 'th', child: Child, column: number) =>
    el(tag, isNumber[column] ? { class: 'number' } : {}, child);
  return el(
    'div',
    { class: 'scrolls', tabindex: 0, role: 'region', 'aria-label': caption },
    el(
      'table',
      {},
      el('caption', {}, caption),
      el('thead', {}, el('tr', {}, ...header.map((name, k) => cell('th', name, k)))),
      el('tbody', {}, ...rows.map((row) => el('tr', {}, ...row.map((child, k) => cell('td', child, k))))),
    ),
  );
}

/** A list of warnings, or nothing. */
export function warnings(title: string, all: string[]): HTMLElement | null {
  if (all.length === 0) return null;
  const list = el('ul', {}, ...[...new Set(all)].map((text) => el('li', {}, text)));
  return el('div', { class: 'warning' }, el('strong', {}, title), list);
}

/** A message that something failed. */
export function failure(text: string): HTMLElement {
  return el('div', { class: 'error', role: 'alert' }, text);
}

/** Five significant digits. */
export function digits(value: number | null | undefined): string {
  if (value == null || !Number.isFinite(value)) return '–';
  const size = Math.abs(value);
  if (size !== 0 && (size < 1e-4 || size >= 1e6)) return value.toExponential(3);
  return String(Number(value.toPrecision(5)));
}

/** A number in five digits; all of its digits are its title. */
export function number(value: number | null | undefined): HTMLElement {
  const title = value == null || !Number.isFinite(value) ? '' : String(value);
  return el('span', { title }, digits(value));
}

/** Offers bytes or text as a file. */
export function download(name: string, content: BlobPart, type = 'text/plain'): void {
  const url = URL.createObjectURL(new Blob([content], { type }));
  const link = el('a', { href: url, download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(url), 10_000);
}

/** Why something failed, for people. */
export function reason(error: unknown): string {
  return error instanceof Error ? error.message : String(error);
}

/** Whether a person has cancelled. */
export function isCancelled(error: unknown): boolean {
  return error instanceof DOMException && error.name === 'AbortError';
}

/** A control that is disabled loses the focus: what this returns gives it back, unless another one has it by then. */
export function refocus(): () => void {
  const focused = document.activeElement;
  return () => {
    if (document.activeElement === document.body && focused instanceof HTMLElement) focused.focus();
  };
}
