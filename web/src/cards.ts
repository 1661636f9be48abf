// The cards of the person's vehicle on the deck: those of step 2, and files of the commands.

import { el, failure, reason } from './dom';
import { useOf, type CardText, type Lab, type Use } from './state';

/** What a card is for, in words. */
export const USES: Record<Use, string> = { thrust: 'Thrust', dynamic: 'Ground effect', empirical: 'Ground effect, empirical law' };

/** The list of cards, with a button for files; files may be dropped on the panel too. */
export function ownCards(lab: Lab, panel: HTMLElement): HTMLElement {
  const list = el('ul', { class: 'cards' });
  const problem = el('div', { id: 'card-problem' });
  const input = el('input', { type: 'file', id: 'card-files', multiple: true, accept: '.toml', class: 'hidden-input', tabindex: -1 });
  const choose = el('button', { type: 'button', id: 'add-card', onclick: () => input.click() }, 'Add card files (TOML)');

  /** The button goes with its card; who has pressed it stays beside the list. */
  function remove(use: Use): void {
    lab.remove(use);
    (list.querySelector('button') ?? choose).focus();
  }

  function show(): void {
    const none = el('li', {}, 'The built-in models fly. Cards of step 2, or card files, replace them.');
    const items = lab.cards.map((card) =>
      el(
        'li',
        {},
        `${USES[card.use]}: ${card.name} `,
        el('button', { type: 'button', 'aria-label': `Remove the card ${card.name}`, onclick: () => remove(card.use) }, 'Remove'),
      ),
    );
    list.replaceChildren(...(items.length > 0 ? items : [none]));
  }

  async function add(files: FileList | null | undefined): Promise<void> {
    problem.replaceChildren();
    for (const file of files ?? []) {
      try {
        const { result } = await lab.calculator.ask<CardText>({ task: 'card', card: file.name }, new Map([[file.name, file]]));
        lab.put({ use: useOf(result), name: result.name, vehicle: result.vehicle, toml: await file.text() });
      } catch (error) {
        problem.append(failure(reason(error)));
      }
    }
    input.value = '';
  }

  input.addEventListener('change', () => void add(input.files));
  panel.addEventListener('drop', (event) => {
    event.preventDefault();
    void add(event.dataTransfer?.files);
  });
  lab.watch(show);
  show();
  return el('div', {}, list, el('div', { class: 'row' }, input, choose), problem);
}
