/** Settings and selections of the user in one flat, observable record. */

import type { Vec3 } from "./protocol";

/** A place on a body of a run. */
export interface Place {
  run: number;
  body: number;
  vertex: number;
}

/** Appearance of a body; bodies without an entry have the default one. */
export interface Look {
  hidden?: boolean;
  transparent?: boolean;
  /** CSS colour that replaces that of its kind. */
  colour?: string;
}

export interface Clip {
  on: boolean;
  /** Normal of the plane, world frame; the positive side is cut away. */
  normal: Vec3;
  /** Distance from the scene centre along the normal, in half sizes of the scene: -1 to 1. */
  offset: number;
}

export interface State {
  /** Displayed instant, s; of modes, s within one period. */
  time: number;
  playing: boolean;
  /** Machine time per real time. */
  speed: number;
  loop: boolean;
  /** Factor on the deformation of flexible bodies. */
  amplification: number;
  /** Index of the displayed mode, if the scene consists of modes. */
  mode: number;
  /** Measure shown by the colours; null: each body has its own colour. */
  measure: string | null;
  rangeMode: "instant" | "run" | "fixed";
  /** Present range of the colours in SI units; null until known. */
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
  /*Appearance by `run:body`, see `key`. */
  looks: Record<string, Look>;
  /** Only visible body, as `run:body`. */
  isolated: string | null;
  /** Visible groups of symbols. */
  symbols: { joint: boolean; force: boolean; sensor: boolean; ground: boolean };
  markers: boolean;
  arrows: boolean;
  /** Arrows of the forces of contacts. */
  touches: boolean;
  /** Shapes of bodies that touch. */
  contacts: boolean;
  /** Factor on the length of arrows. */
  arrowScale: number;
  grid: boolean;
  shadows: boolean;
  clip: Clip;
  /** Points with drawn paths. */
  traces: Place[];
  perspective: boolean;
  /** Body followed by the camera, as `run:body`. */
  follow: string | null;
  theme: "auto" | "light" | "dark";
  /** Visible runs; the first one is drawn in full, others as overlays. */
  runs: boolean[];
  /*Offset of run number k relative to the first run: k times this vector, m. */
  offset: Vec3;
  /** Active mouse tool. */
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
  touches: true,
  contacts: true,
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

/** Record with observers, which are called at once in the order of their registration. */
export class Store {
  private record: State;
  private watchers: { keys: ReadonlySet<keyof State> | null; call: Watcher }[] = [];

  constructor(start: State = initial()) {
    this.record = start;
  }

  get state(): Readonly<State> {
    return this.record;
  }

  /** Change some entries; equal values have no effect. */
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

  /** Call a function now and after each change of given entries; returns the function that unsubscribes. */
  watch(keys: (keyof State)[] | null, call: Watcher): () => void {
    const entry = { keys: keys && new Set(keys), call };
    this.watchers.push(entry);
    call(this.record, new Set(keys ?? (Object.keys(this.record) as (keyof State)[])));
    return () => {
      this.watchers = this.watchers.filter((other) => other !== entry);
    };
  }
}
