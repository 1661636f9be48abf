// Number fields: what they take, and what is wrong with what they hold, in words beside them.

import { el } from './dom';
import { expected, numberOf, type NumberLimits } from './number';

let isPressed = false;
addEventListener('pointerdown', () => (isPressed = true), true);
for (const end of ['pointerup', 'pointercancel']) addEventListener(end, () => (isPressed = false), true);

/** Calls after the press that has left a field: a message that moves a button from under the pointer would swallow its click. */
function afterPress(call: () => void): void {
  // A press of a finger ends before the field is left, and its click comes in the same task.
  const soon = () => setTimeout(call);
  if (!isPressed) return void soon();
  const press = new AbortController();
  const ended = () => {
    press.abort();
    soon();
  };
  for (const end of ['pointerup', 'pointercancel']) addEventListener(end, ended, { capture: true, signal: press.signal });
}

/** A text field for a number. A browser's own number field hides from the page what it cannot read, and drops commas. */
export class NumberField {
  readonly element: HTMLElement;
  readonly input: HTMLInputElement;
  private readonly error: HTMLElement;

  constructor(
    id: string,
    label: string,
    private readonly limits: NumberLimits,
  ) {
    const inputmode = limits.whole ? 'numeric' : 'decimal';
    this.input = el('input', { id, type: 'text', inputmode, autocomplete: 'off', spellcheck: 'false' });
    this.error = el('span', { id: `${id}-error`, class: 'field-error', role: 'alert' });
    const name = el('label', { for: id }, label);
    this.element = el('div', { class: 'field' }, name, this.input, this.error);
    this.input.addEventListener('change', () => afterPress(() => this.check()));
    this.input.addEventListener('input', () => {
      // What is being mended is not blamed again before it is complete, and not longer than it is wrong.
      if (this.input.hasAttribute('aria-invalid') && this.isValid()) this.check();
    });
  }

  set(value: number): void {
    this.input.value = String(value);
    this.check();
  }

  /** The number; undefined where the field is empty, or where what it holds is none. */
  value(): number | undefined {
    return numberOf(this.text(), this.limits);
  }

  /** Says what is wrong beside the field; whether nothing is. */
  check(): boolean {
    const isValid = this.isValid();
    if (isValid) {
      this.error.textContent = '';
      this.input.removeAttribute('aria-invalid');
      this.input.removeAttribute('aria-describedby');
    } else {
      const found = this.text() === '' ? 'nothing' : `“${this.text()}”`;
      this.error.textContent = `${expected(this.limits)}; found ${found}`;
      this.input.setAttribute('aria-invalid', 'true');
      this.input.setAttribute('aria-describedby', this.error.id);
    }
    return isValid;
  }

  private text(): string {
    return this.input.value.trim();
  }

  private isValid(): boolean {
    return this.text() === '' ? this.limits.optional === true : this.value() !== undefined;
  }
}

/** Checks fields, and moves to the first that is wrong; whether none is. */
export function checkAll(fields: NumberField[]): boolean {
  const wrong = fields.filter((field) => !field.check());
  wrong[0]?.input.focus();
  return wrong.length === 0;
}
