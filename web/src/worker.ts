// Runs the calculations: one request, one run of the program.

import { Failure, Program, type Input } from './wasi';

/** What the page sends to a worker. */
export interface Job {
  module: WebAssembly.Module;
  request: unknown;
  files: Map<string, Input>;
}

/** What a worker sends back: stages of the calculation, then its end. */
export type Report =
  | { stage: string }
  | { result: unknown; written: Map<string, Uint8Array>; memory: number }
  | { error: string; memory: number };

addEventListener('message', (event: MessageEvent<Job>) => {
  const { module, request, files } = event.data;
  let report: Report;
  try {
    const run = new Program(files, JSON.stringify(request), passOn).run(module);
    const answer = JSON.parse(run.stdout) as { result?: unknown; error?: string };
    const { memory } = run;
    report =
      answer.error === undefined
        ? { result: answer.result, written: run.written, memory }
        : { error: answer.error, memory };
  } catch (error) {
    // A program that stopped may have had any memory.
    const text = error instanceof Failure ? error.message : `the calculation stopped: ${String(error)}`;
    report = { error: text, memory: Infinity };
  }
  postMessage(report);
});

/** Sends a stage to the page; whether the line is one. */
function passOn(line: string): boolean {
  if (!line.startsWith('{"stage":')) return false;
  postMessage(JSON.parse(line) as Report);
  return true;
}
