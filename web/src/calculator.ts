// Requests to the calculations, each in a worker of its own run. To cancel a request is to end its worker.

import workerSource from 'worker:./worker.ts';
import type { Job, Report } from './worker';
import type { Input } from './wasi';

/** What a request returns. */
export interface Answer<T> {
  result: T;
  written: Map<string, Uint8Array>;
}

declare global {
  interface Window {
    /** The program, compressed, as text. A script of its own sets it. */
    touchdownProgram: string;
  }
}

/** The program's bytes, of which the page brings a compressed copy as text. */
async function programBytes(): Promise<ArrayBuffer> {
  const packed = Uint8Array.from(atob(window.touchdownProgram), (c) => c.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream('gzip'));
  return new Response(stream).arrayBuffer();
}

/** Memory of a run above which its worker is ended, in bytes: an idle one may keep it for minutes. */
const MOST_IDLE = 128e6;

export class Calculator {
  private module: Promise<WebAssembly.Module> | undefined;
  private readonly url: string;
  private readonly idle: Worker[] = [];

  constructor() {
    this.url = URL.createObjectURL(new Blob([workerSource], { type: 'text/javascript' }));
  }

  /** Compiles the program; later calls wait for the same. */
  ready(): Promise<WebAssembly.Module> {
    this.module ??= programBytes().then((bytes) => WebAssembly.compile(bytes));
    return this.module;
  }

  /** Asks for a result. `files` are what the program may read, by path without the first slash; `stage` hears what a calculation begins. */
  async ask<T>(
    request: Record<string, unknown>,
    files: Map<string, Input> = new Map(),
    signal?: AbortSignal,
    stage?: (text: string) => void,
  ): Promise<Answer<T>> {
    const module = await this.ready();
    signal?.throwIfAborted();
    const worker = this.idle.pop() ?? new Worker(this.url);
    return new Promise((resolve, reject) => {
      const cancel = () => {
        worker.terminate();
        reject(new DOMException('cancelled', 'AbortError'));
      };
      signal?.addEventListener('abort', cancel, { once: true });
      worker.onmessage = (event: MessageEvent<Report>) => {
        if ('stage' in event.data) return stage?.(event.data.stage);
        signal?.removeEventListener('abort', cancel);
        const report = event.data;
        if (report.memory > MOST_IDLE) worker.terminate();
        else this.idle.push(worker);
        if ('error' in report) reject(new Error(report.error));
        else resolve({ result: report.result as T, written: report.written });
      };
      worker.onerror = (event) => {
        signal?.removeEventListener('abort', cancel);
        worker.terminate();
        reject(new Error(event.message || 'the worker stopped'));
      };
      worker.postMessage({ module, request, files } satisfies Job);
    });
  }
}
