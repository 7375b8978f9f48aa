/** What the user sees and has chosen: one flat record that can be watched. */

import type { Vec3 } from "./protocol";

/** A place on a body of a run. */
export interface Place {
  run: number;
  body: number;
  vertex: number;
}

/** How a body is shown; bodies without an entry are shown as they are. */
export interface Look {
  hidden?: boolean;
  transparent?: boolean;
  /** CSS colour in place of that of its kind. */
  colour?: string;
}

export interface Clip {
  on: boolean;
  /** Normal of the plane, world frame; what lies on its positive side is cut away. */
  normal: Vec3;
  /** Distance from the middle of the scene along the normal, in halves of its size: -1 to 1. */
  offset: number;
}

export interface State {
  /** Instant that is shown, s; of modes, s within one period. */
  time: number;
  playing: boolean;
  /** Seconds of the machine a second of the watch. */
  speed: number;
  loop: boolean;
  /** Factor on the deformation of flexible bodies. */
  amplification: number;
  /** Number of the mode that is shown, if the scene consists of modes. */
  mode: number;
  /** What the colours mean, one of the scene's measures; null: each body has its own colour. */
  measure: string | null;
  rangeMode: "instant" | "run" | "fixed";
  /** Lowest and highest value of the colours now, in SI units; null until it is known. */
  range: [number, number] | null;
  map: string;
  /** Number of bands of constant colour; 0: smooth. */
  bands: number;
  isolines: boolean;
  edges: boolean;
  /** Edges of all triangles. */
  mesh: boolean;
  /** Colours without light, to compare them with the legend. */
  flat: boolean;
  selection: Place | null;
  hover: Place | null;
  /** By `run:body`, as `key` writes it. */
  looks: Record<string, Look>;
  /** Body that alone is shown, as `run:body`. */
  isolated: string | null;
  /** Groups of symbols that are shown. */
  symbols: { joint: boolean; force: boolean; sensor: boolean; ground: boolean };
  markers: boolean;
  arrows: boolean;
  /** Factor on the length of arrows. */
  arrowScale: number;
  grid: boolean;
  shadows: boolean;
  clip: Clip;
  /** Points whose paths are drawn. */
  traces: Place[];
  perspective: boolean;
  /** Body that the camera follows, as `run:body`. */
  follow: string | null;
  theme: "auto" | "light" | "dark";
  /** Which runs are shown; the first one is drawn in full, others as overlays. */
  runs: boolean[];
  /** Run number k stands k times this beside the first, m. */
  offset: Vec3;
  /** What the mouse does on the picture. */
  tool: "select" | "measure" | "pull";
  message: string;
}

export const initial = (): State => ({
  time: 0,
  playing: false,
  speed: 1,
  loop: true,
  amplification: 1,
  mode: 0,
  measure: null,
  rangeMode: "run",
  range: null,
  map: "spectrum",
  bands: 0,
  isolines: false,
  edges: true,
  mesh: false,
  flat: false,
  selection: null,
  hover: null,
  looks: {},
  isolated: null,
  symbols: { joint: true, force: true, sensor: true, ground: true },
  markers: false,
  arrows: true,
  arrowScale: 1,
  grid: true,
  shadows: true,
  clip: { on: false, normal: [0, 1, 0], offset: 0 },
  traces: [],
  perspective: true,
  follow: null,
  theme: "auto",
  runs: [true],
  offset: [0, 0, 0],
  tool: "select",
  message: "",
});

export type Watcher = (state: Readonly<State>, changed: ReadonlySet<keyof State>) => void;

export const key = (run: number, body: number): string => `${run}:${body}`;

/** The record and who watches it: watchers are called at once, in the order in which they came. */
export class Store {
  private record: State;
  private watchers: { keys: ReadonlySet<keyof State> | null; call: Watcher }[] = [];

  constructor(start: State = initial()) {
    this.record = start;
  }

  get state(): Readonly<State> {
    return this.record;
  }

  /** Change some entries; those that are equal to what they were change nothing. */
  set(change: Partial<State>): void {
    const changed = new Set<keyof State>();
    for (const name of Object.keys(change) as (keyof State)[]) {
      if (!Object.is(change[name], this.record[name])) changed.add(name);
    }
    if (!changed.size) return;
    this.record = { ...this.record, ...change };
    for (const { keys, call } of [...this.watchers]) {
      if (!keys || [...changed].some((name) => keys.has(name))) call(this.record, changed);
    }
  }

  /** Call a function now and after each change of one of these entries; returns what ends it. */
  watch(keys: (keyof State)[] | null, call: Watcher): () => void {
    const entry = { keys: keys && new Set(keys), call };
    this.watchers.push(entry);
    call(this.record, new Set(keys ?? (Object.keys(this.record) as (keyof State)[])));
    return () => {
      this.watchers = this.watchers.filter((other) => other !== entry);
    };
  }
}
