// A WASI program's world in a worker: its standard streams, and a folder of files that are read slice by slice.
// Only what a Rust program that reads and writes files calls is here; all else reports that it is not supported.

/** A file that the program may read: a file of the person's disk, or bytes. */
export type Input = Blob | Uint8Array;

/** What a run leaves behind. */
export interface Run {
  /** Memory that the program had, in bytes. */
  memory: number;
  status: number;
  stdout: string;
  stderr: string;
  /** Files that the program wrote, by name. */
  written: Map<string, Uint8Array>;
}

const OK = 0;
const BAD_DESCRIPTOR = 8;
const NO_ENTRY = 44;
const NOT_SUPPORTED = 52;
const INVALID = 28;
const FOLDER = 3;
const FILE = 4;
const STREAM = 2;
/** The one folder that the program sees, by its descriptor. */
const ROOT = 3;
/** Bytes that are read from a disk at once, and at most where a file is read from its start to its end: reading takes half as long. */
const WINDOW = 1 << 20;
const WIDEST = 1 << 23;
/** What a program says that finds no more memory. */
const NO_MEMORY =
  'The calculation needs more memory than a browser gives it (4 GB). Use fewer rows: in the map, [[windows]] takes parts of a log, and ' +
  '[resample] makes its rows fewer. The command `touchdown` has no such limit.';
const ALL_RIGHTS = 0xffffffffffffffffn;

class Exit extends Error {
  constructor(readonly status: number) {
    super(`exit ${status}`);
  }
}

/** Why a program has no answer, in words for people. */
export class Failure extends Error {}

/** A slice of a file. */
function slice(of: Blob, name: string, from: number, to: number): Uint8Array<ArrayBuffer> {
  try {
    return new Uint8Array(new FileReaderSync().readAsArrayBuffer(of.slice(from, to)));
  } catch {
    throw new Failure(`${name}: the browser can no longer read this file: it was changed, moved or deleted since it was dropped, or it is a folder. Drop it again.`);
  }
}

/** A port that nobody listens to. */
const nobody = (() => {
  const { port1, port2 } = new MessageChannel();
  port2.close();
  return port1;
})();

/** Frees the memory of a slice: Chromium kept all slices until the end of a calculation, which is the whole file. */
function free({ buffer }: Uint8Array<ArrayBuffer>): void {
  nobody.postMessage(null, [buffer]);
}

/** Reads a file slice by slice. */
class Source {
  readonly size: number;
  private from = 0;
  private window = new Uint8Array();

  constructor(
    private readonly input: Input,
    private readonly name: string,
  ) {
    this.size = input instanceof Blob ? input.size : input.length;
  }

  read(at: number, into: Uint8Array): number {
    const end = Math.min(at + into.length, this.size);
    if (end <= at) return 0;
    if (!(this.input instanceof Blob)) {
      into.set(this.input.subarray(at, end));
      return end - at;
    }
    if (at < this.from || at >= this.from + this.window.length) {
      const { length } = this.window;
      const wanted = length > 0 && at === this.from + length ? Math.min(2 * length, WIDEST) : WINDOW;
      free(this.window);
      this.window = slice(this.input, this.name, at, Math.min(at + wanted, this.size));
      this.from = at;
    }
    const part = this.window.subarray(at - this.from, end - this.from);
    into.set(part);
    return part.length;
  }
}

/** What a program writes. */
class Sink {
  private readonly chunks: Uint8Array[] = [];
  size = 0;

  write(bytes: Uint8Array): void {
    this.chunks.push(bytes.slice());
    this.size += bytes.length;
  }

  bytes(): Uint8Array {
    const all = new Uint8Array(this.size);
    let at = 0;
    for (const chunk of this.chunks) {
      all.set(chunk, at);
      at += chunk.length;
    }
    return all;
  }

  text(): string {
    return new TextDecoder().decode(this.bytes());
  }
}

interface Descriptor {
  kind: number;
  source?: Source;
  sink?: Sink;
  at: number;
}

/** One run of a program. */
export class Program {
  private memory!: WebAssembly.Memory;
  private readonly stdout = new Sink();
  private readonly stderr = new Sink();
  private readonly written = new Map<string, Sink>();
  private readonly open: (Descriptor | undefined)[];

  constructor(
    private readonly files: Map<string, Input>,
    stdin: string,
    /** Takes lines of standard error as they come; those that it does not know are what a panic says. */
    private readonly known: (line: string) => boolean = () => false,
  ) {
    this.open = [
      { kind: STREAM, source: new Source(new TextEncoder().encode(stdin), 'the request'), at: 0 },
      { kind: STREAM, sink: this.stdout, at: 0 },
      { kind: STREAM, sink: this.stderr, at: 0 },
      { kind: FOLDER, at: 0 },
    ];
  }

  run(module: WebAssembly.Module): Run {
    const instance = new WebAssembly.Instance(module, {
      wasi_snapshot_preview1: this.imports(module),
    });
    this.memory = instance.exports.memory as WebAssembly.Memory;
    let status = 0;
    try {
      (instance.exports._start as () => void)();
    } catch (error) {
      if (!(error instanceof Exit)) {
        if (error instanceof Failure) throw error;
        // A trap: what the program has said of it is on its standard error.
        const said = this.stderr.text();
        throw new Failure(/memory allocation of \d+ bytes failed/.test(said) ? NO_MEMORY : `the calculation stopped: ${said === '' ? String(error) : said}`);
      }
      status = error.status;
    }
    const written = new Map<string, Uint8Array>();
    for (const [name, sink] of this.written) written.set(name, sink.bytes());
    return { memory: this.memory.buffer.byteLength, status, stdout: this.stdout.text(), stderr: this.stderr.text(), written };
  }

  private imports(module: WebAssembly.Module): Record<string, WebAssembly.ImportValue> {
    const own = this.calls();
    const all: Record<string, WebAssembly.ImportValue> = {};
    for (const { name } of WebAssembly.Module.imports(module)) {
      all[name] = own[name] ?? (() => NOT_SUPPORTED);
    }
    return all;
  }

  private view(): DataView {
    return new DataView(this.memory.buffer);
  }

  private bytes(at: number, length: number): Uint8Array {
    return new Uint8Array(this.memory.buffer, at, length);
  }

  private name(at: number, length: number): string {
    return new TextDecoder().decode(this.bytes(at, length)).replace(/^\.?\//, '');
  }

  /** Each buffer of a list of buffers, until one is not filled. */
  private each(list: number, count: number, use: (part: Uint8Array) => number): number {
    let total = 0;
    for (let k = 0; k < count; k++) {
      const view = this.view();
      const at = view.getUint32(list + 8 * k, true);
      const length = view.getUint32(list + 8 * k + 4, true);
      const used = use(this.bytes(at, length));
      total += used;
      if (used < length) break;
    }
    return total;
  }

  private stat(at: number, kind: number, size: number): number {
    this.bytes(at, 64).fill(0);
    this.view().setUint8(at + 16, kind);
    this.view().setBigUint64(at + 24, 1n, true);
    this.view().setBigUint64(at + 32, BigInt(size), true);
    return OK;
  }

  private calls(): Record<string, (...args: never[]) => number | void> {
    const none = (count: number, size: number): number => {
      this.view().setUint32(count, 0, true);
      this.view().setUint32(size, 0, true);
      return OK;
    };
    return {
      args_sizes_get: none,
      args_get: () => OK,
      environ_sizes_get: none,
      environ_get: () => OK,
      clock_time_get: (_id: number, _precision: bigint, at: number) => {
        this.view().setBigUint64(at, BigInt(Math.round(performance.now() * 1e6)), true);
        return OK;
      },
      random_get: (at: number, length: number) => {
        const random = new Uint8Array(length);
        crypto.getRandomValues(random);
        this.bytes(at, length).set(random);
        return OK;
      },
      sched_yield: () => OK,
      proc_exit: (status: number) => {
        throw new Exit(status);
      },
      ...this.descriptorCalls(),
      ...this.pathCalls(),
    };
  }

  private descriptorCalls(): Record<string, (...args: never[]) => number> {
    return {
      fd_prestat_get: (fd: number, at: number) => {
        if (fd !== ROOT) return BAD_DESCRIPTOR;
        this.view().setUint32(at, 0, true);
        this.view().setUint32(at + 4, 1, true);
        return OK;
      },
      fd_prestat_dir_name: (fd: number, at: number, length: number) => {
        if (fd !== ROOT || length < 1) return INVALID;
        this.bytes(at, 1).set([0x2f]);
        return OK;
      },
      fd_fdstat_get: (fd: number, at: number) => {
        const open = this.open[fd];
        if (!open) return BAD_DESCRIPTOR;
        this.bytes(at, 24).fill(0);
        this.view().setUint8(at, open.kind);
        this.view().setBigUint64(at + 8, ALL_RIGHTS, true);
        this.view().setBigUint64(at + 16, ALL_RIGHTS, true);
        return OK;
      },
      fd_filestat_get: (fd: number, at: number) => {
        const open = this.open[fd];
        if (!open) return BAD_DESCRIPTOR;
        return this.stat(at, open.kind, open.source?.size ?? open.sink?.size ?? 0);
      },
      fd_read: (fd: number, list: number, count: number, out: number) => {
        const open = this.open[fd];
        const source = open?.source;
        if (!open || !source) return BAD_DESCRIPTOR;
        const read = this.each(list, count, (part) => {
          const got = source.read(open.at, part);
          open.at += got;
          return got;
        });
        this.view().setUint32(out, read, true);
        return OK;
      },
      fd_write: (fd: number, list: number, count: number, out: number) => {
        const sink = this.open[fd]?.sink;
        if (!sink) return BAD_DESCRIPTOR;
        const wrote = this.each(list, count, (part) => {
          const isKnown = sink === this.stderr && this.known(new TextDecoder().decode(part));
          if (!isKnown) sink.write(part);
          return part.length;
        });
        this.view().setUint32(out, wrote, true);
        return OK;
      },
      fd_seek: (fd: number, offset: bigint, whence: number, out: number) => {
        const open = this.open[fd];
        if (!open?.source || open.kind !== FILE) return BAD_DESCRIPTOR;
        const from = [0, open.at, open.source.size][whence];
        if (from === undefined || from + Number(offset) < 0) return INVALID;
        open.at = from + Number(offset);
        this.view().setBigUint64(out, BigInt(open.at), true);
        return OK;
      },
      fd_tell: (fd: number, out: number) => {
        const open = this.open[fd];
        if (!open) return BAD_DESCRIPTOR;
        this.view().setBigUint64(out, BigInt(open.at), true);
        return OK;
      },
      fd_close: (fd: number) => {
        if (!this.open[fd]) return BAD_DESCRIPTOR;
        this.open[fd] = undefined;
        return OK;
      },
    };
  }

  private pathCalls(): Record<string, (...args: never[]) => number> {
    return {
      path_filestat_get: (_fd: number, _flags: number, path: number, length: number, at: number) => {
        const name = this.name(path, length);
        const input = this.files.get(name);
        if (input) return this.stat(at, FILE, new Source(input, name).size);
        const inside = `${name}/`;
        const isFolder = name === '' || [...this.files.keys()].some((file) => file.startsWith(inside));
        return isFolder ? this.stat(at, FOLDER, 0) : NO_ENTRY;
      },
      path_open: (
        _fd: number,
        _lookup: number,
        path: number,
        length: number,
        how: number,
        _base: bigint,
        _inheriting: bigint,
        _flags: number,
        out: number,
      ) => {
        const name = this.name(path, length);
        const input = this.files.get(name);
        const create = (how & 1) !== 0;
        let opened: Descriptor;
        if (create) {
          const sink = new Sink();
          this.written.set(name.slice(name.lastIndexOf('/') + 1), sink);
          opened = { kind: FILE, sink, at: 0 };
        } else if (input) {
          opened = { kind: FILE, source: new Source(input, name), at: 0 };
        } else {
          return NO_ENTRY;
        }
        this.open.push(opened);
        this.view().setUint32(out, this.open.length - 1, true);
        return OK;
      },
    };
  }
}
