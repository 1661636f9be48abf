// Runs the calculations: one request, one run of the program.

import { Program, type Input } from './wasi';

/** What the page sends to a worker. */
export interface Job {
  module: WebAssembly.Module;
  request: unknown;
  files: Map<string, Input>;
}

/** What a worker sends back: stages of the calculation, then its end. */
export type Report =
  | { stage: string }
  | { result: unknown; written: Map<string, Uint8Array> }
  | { error: string };

addEventListener('message', (event: MessageEvent<Job>) => {
  const { module, request, files } = event.data;
  let report: Report;
  try {
    const run = new Program(files, JSON.stringify(request), passOn).run(module);
    const answer = JSON.parse(run.stdout) as { result?: unknown; error?: string };
    report =
      answer.error === undefined
        ? { result: answer.result, written: run.written }
        : { error: answer.error };
  } catch (error) {
    const text = error instanceof Error ? error.message : String(error);
    report = { error: `the calculation stopped: ${text}` };
  }
  postMessage(report);
});

/** Sends a stage to the page; whether the line is one. */
function passOn(line: string): boolean {
  if (!line.startsWith('{"stage":')) return false;
  postMessage(JSON.parse(line) as Report);
  return true;
}
