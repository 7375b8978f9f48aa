/** Rows of a run over time: stored frames loaded in pieces, modes, or a running machine. */

import type { Mode, Scene } from "../protocol";
import type { Freedom } from "./joints";
import { setFreedoms } from "./joints";
import type { Source } from "../source/source";

export interface Track {
  /** Instants of the frames, s; empty for static scenes. */
  readonly times: ArrayLike<number>;
  readonly start: number;
  readonly end: number;
  /** Row at an instant between frames; the nearest loaded row until they are loaded. */
  row(time: number): Float64Array;
  /** Resolves once the row at an instant is loaded. */
  ready(time: number): Promise<void>;
  /** Subscribe to new rows or times; returns the function that unsubscribes. */
  onChange(call: () => void): () => void;
}

/** Columns of the row at which Euler parameters start. */
export function turns(scene: Scene): number[] {
  const found = new Set<number>();
  for (const body of scene.bodies) {
    if (body.place >= 0) found.add(body.place + 3);
    body.rings?.places.data.forEach((place) => found.add(place + 3));
  }
  for (const { side } of scene.markers) if (side.place >= 0) found.add(side.place + 3);
  for (const symbol of scene.symbols) {
    for (const side of symbol.sides) if (side.place >= 0) found.add(side.place + 3);
  }
  return [...found];
}

/** Interpolated row at share `f` between two rows; Euler parameters along the shorter arc. */
export function blend(a: ArrayLike<number>, b: ArrayLike<number>, f: number, turned: number[], out: Float64Array): Float64Array {
  for (let i = 0; i < out.length; i++) out[i] = a[i] + f * (b[i] - a[i]);
  for (const at of turned) {
    if (a[at] * b[at] + a[at + 1] * b[at + 1] + a[at + 2] * b[at + 2] + a[at + 3] * b[at + 3] >= 0) continue;
    for (let i = at; i < at + 4; i++) out[i] = a[i] - f * (b[i] + a[i]);
  }
  return out;
}

/** Index of the last ascending instant that is not after a time; at least 0. */
export function before(times: ArrayLike<number>, time: number): number {
  let low = 0, high = times.length - 1;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (times[middle] <= time) low = middle;
    else high = middle - 1;
  }
  return low;
}

class Listeners {
  private calls = new Set<() => void>();

  onChange(call: () => void): () => void {
    this.calls.add(call);
    return () => this.calls.delete(call);
  }

  protected changed(): void {
    for (const call of [...this.calls]) call();
  }
}

/** Static scene; joints of a machine can be set. */
export class StillTrack extends Listeners implements Track {
  readonly times: ArrayLike<number> = [];
  readonly start = 0;
  readonly end = 0;
  private shown: Float64Array;

  constructor(private scene: Scene) {
    super();
    this.shown = scene.still.data;
  }

  /** Set joint freedoms to values, rad or m, relative to the model's pose. */
  pose(all: readonly Freedom[], values: readonly number[]): void {
    this.shown = setFreedoms(all, values, Float64Array.from(this.scene.still.data));
    this.changed();
  }

  /** Whether joints were set. */
  get moved(): boolean {
    return this.shown !== this.scene.still.data;
  }

  row(): Float64Array {
    return this.shown;
  }

  async ready(): Promise<void> {}
}

/** One period of a mode: `still + a (real cos wt - imag sin wt)`. */
export class ModeTrack extends Listeners implements Track {
  readonly times: ArrayLike<number> = [];
  readonly start = 0;
  private chosen: Mode;
  private out: Float64Array;

  constructor(private scene: Scene) {
    super();
    this.chosen = scene.modes![0];
    this.out = new Float64Array(scene.row);
  }

  /** Period, s; 1 s for a mode of zero frequency. */
  get end(): number {
    return this.chosen.frequency > 0 ? 1 / this.chosen.frequency : 1;
  }

  choose(mode: number): void {
    const modes = this.scene.modes!;
    this.chosen = modes[Math.max(0, Math.min(mode, modes.length - 1))];
    this.changed();
  }

  row(time: number): Float64Array {
    const { real, imag, amplitude } = this.chosen;
    const angle = (2 * Math.PI * time) / this.end;
    const c = amplitude * Math.cos(angle), s = amplitude * Math.sin(angle);
    const still = this.scene.still.data;
    for (let i = 0; i < this.out.length; i++) {
      this.out[i] = still[i] + c * real.data[i] - (imag ? s * imag.data[i] : 0);
    }
    return this.out;
  }

  async ready(): Promise<void> {}
}

/** Last row received from a running machine. */
export class LiveTrack extends Listeners implements Track {
  readonly times: ArrayLike<number> = [];
  readonly start = 0;
  end = 0;
  private last: Float64Array;

  constructor(scene: Scene) {
    super();
    this.last = Float64Array.from(scene.still.data);
  }

  push(time: number, row: ArrayLike<number>): void {
    this.end = time;
    this.last.set(row);
    this.changed();
  }

  row(): Float64Array {
    return this.last;
  }

  async ready(): Promise<void> {}
}

const PIECE = 1 << 20; // bytes of one request
const KEPT = 1 << 28; // bytes of loaded rows that are kept

/** Stored frames, loaded in pieces on demand. */
export class FramesTrack extends Listeners implements Track {
  times: Float64Array;
  private pieces = new Map<number, Float32Array | Float64Array>();
  private asked = new Map<number, Promise<void>>();
  private out: Float64Array;
  private turned: number[];
  private nr: number;
  private size: number;
  private generation = 0;

  constructor(
    private source: Source,
    private scene: Scene,
    private run: number,
  ) {
    super();
    this.times = scene.frames.data;
    this.nr = scene.row;
    this.size = Math.max(1, Math.min(4096, Math.floor(PIECE / (4 * this.nr))));
    this.turned = turns(scene);
    this.out = new Float64Array(this.nr);
  }

  get start(): number {
    return this.times[0];
  }

  get end(): number {
    return this.times[this.times.length - 1];
  }

  /** Request the frames of another time window. */
  async window(start: number, end: number): Promise<void> {
    const answer = await this.source.window(this.run, start, end);
    this.generation++;
    this.times = answer.frames.data;
    this.pieces.clear();
    this.asked.clear();
    this.changed();
  }

  row(time: number): Float64Array {
    const i = before(this.times, time);
    const j = Math.min(i + 1, this.times.length - 1);
    const a = this.frame(i) ?? this.nearest(i);
    const b = this.frame(j) ?? a;
    // prefetch the next piece
    if ((i % this.size) * 2 > this.size) void this.load(Math.floor(i / this.size) + 1);
    if (!a || !b) return this.scene.still.data;
    const span = this.times[j] - this.times[i];
    const f = span > 0 ? Math.max(0, Math.min(1, (time - this.times[i]) / span)) : 0;
    return blend(a, b, f, this.turned, this.out);
  }

  async ready(time: number): Promise<void> {
    const i = before(this.times, time);
    const j = Math.min(i + 1, this.times.length - 1);
    await Promise.all([this.load(Math.floor(i / this.size)), this.load(Math.floor(j / this.size))]);
  }

  private frame(i: number): Float32Array | Float64Array | null {
    const number = Math.floor(i / this.size);
    const piece = this.pieces.get(number);
    if (!piece) {
      void this.load(number);
      return null;
    }
    // the map is in least-recently-used order: drop the first piece
    this.pieces.delete(number);
    this.pieces.set(number, piece);
    const at = (i - number * this.size) * this.nr;
    return at + this.nr <= piece.length ? piece.subarray(at, at + this.nr) : null;
  }

  private nearest(i: number): Float32Array | Float64Array | null {
    let best: number | null = null;
    const number = Math.floor(i / this.size);
    for (const known of this.pieces.keys()) {
      if (best === null || Math.abs(known - number) < Math.abs(best - number)) best = known;
    }
    if (best === null) return null;
    const piece = this.pieces.get(best)!;
    const count = piece.length / this.nr;
    const k = best < number ? count - 1 : 0;
    return piece.subarray(k * this.nr, (k + 1) * this.nr);
  }

  private load(number: number): Promise<void> {
    const first = number * this.size;
    if (this.pieces.has(number) || number < 0 || first >= this.times.length) return Promise.resolve();
    const under = this.asked.get(number);
    if (under) return under;
    const generation = this.generation;
    const count = Math.min(this.size, this.times.length - first);
    const work = this.source.rows(this.run, first, count, 1).then(
      (answer) => {
        if (generation !== this.generation) return;
        this.asked.delete(number);
        this.pieces.set(number, answer.rows.data);
        while (this.pieces.size > 2 && this.pieces.size * this.size * this.nr * 4 > KEPT) {
          this.pieces.delete(this.pieces.keys().next().value!);
        }
        this.changed();
      },
      (error: unknown) => {
        this.asked.delete(number);
        throw error;
      },
    );
    this.asked.set(number, work);
    work.catch(() => undefined); // the caller that waits for the rows gets the error
    return work;
  }
}

export function makeTrack(source: Source, scene: Scene, run: number): Track {
  if (scene.what === "live") return new LiveTrack(scene);
  if (scene.modes?.length) return new ModeTrack(scene);
  if (scene.frames.data.length > 1) return new FramesTrack(source, scene, run);
  return new StillTrack(scene);
}
