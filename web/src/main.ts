// The page: three steps in tabs.

import './style.css';
import { Calculator } from './calculator';
import { deckStep } from './deck';
import { logStep } from './log';
import { modelStep } from './model';
import { Lab } from './state';

const STEPS = ['log', 'model', 'deck'] as const;
type Step = (typeof STEPS)[number];

const byId = (id: string) => document.getElementById(id)!;
const lab = new Lab(new Calculator());
logStep(byId('log'), lab);
modelStep(byId('model'), lab);
const deck = deckStep(byId('deck'), lab);

function open(step: Step, focus = false): void {
  for (const each of STEPS) {
    const tab = byId(`tab-${each}`);
    const chosen = each === step;
    tab.setAttribute('aria-selected', String(chosen));
    tab.tabIndex = chosen ? 0 : -1;
    byId(each).hidden = !chosen;
    if (chosen && focus) tab.focus();
  }
  if (step === 'deck') deck.shown();
}

STEPS.forEach((step, k) => {
  const tab = byId(`tab-${step}`);
  tab.addEventListener('click', () => open(step));
  tab.addEventListener('keydown', (event) => {
    const to = { ArrowRight: k + 1, ArrowLeft: k - 1, Home: 0, End: STEPS.length - 1 }[event.key];
    if (to === undefined) return;
    event.preventDefault();
    open(STEPS[(to + STEPS.length) % STEPS.length]!, true);
  });
});

// The deck flies the scenario of an address that a person types or pastes.
addEventListener('hashchange', () => open('deck'));

// A dropped file that misses the zone must not replace the page.
for (const name of ['dragover', 'drop']) addEventListener(name, (event) => event.preventDefault());

addEventListener('load', () => {
  void lab.calculator.ready().then(() => {
    performance.mark('ready');
    document.documentElement.setAttribute('data-ready', '');
  });
  // A link to a scenario shows it.
  if (location.hash.length > 1) open('deck');
});
