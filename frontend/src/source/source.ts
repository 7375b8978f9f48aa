/**
 * Where scenes and numbers come from: a server (`socket.ts`), data in the page (`file.ts`) or a
 * machine that runs in it (`engine.ts`).
 */

import type { History, Live, Probe, Rows, Scene, Window, Worst } from "../protocol";

export interface Source {
  /** Whether numbers come from double precision, or with 7 digits from the page. */
  readonly exact: boolean;
  /** Whether a machine runs behind it. */
  readonly live: boolean;
  /** Whether a server answers. */
  readonly served: boolean;
  scene(run: number): Promise<Scene>;
  /** Rows of `count` frames from number `first`, one in `every`. */
  rows(run: number, first: number, count: number, every: number): Promise<Rows>;
  /** Frames of another window of a long run; rows count in it from then on. */
  window(run: number, start: number, end: number): Promise<Window>;
  probe(run: number, body: number, vertex: number, time: number): Promise<Probe>;
  /** Histories at a vertex; `of`: measures, `s11`, `ux`, `x`, `damage` and the like. */
  history(run: number, body: number, vertex: number, of: string[], most: number): Promise<History>;
  sensor(run: number, names: string[], most: number): Promise<History>;
  worst(run: number, measure: string, count: number): Promise<Worst[]>;
  extent(run: number, measure: string): Promise<[number, number]>;
  /** Orders to a running machine: `{do: "play"}` and the like. */
  order(order: Record<string, unknown>): Promise<void>;
  /** Call a function for each state that a running machine sends; returns what ends it. */
  onLive(call: (live: Live) => void): () => void;
}
