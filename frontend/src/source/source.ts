/**
 * Where scenes and numbers come from: a server (`socket.ts`), data in the page (`file.ts`) or a
 * machine that runs in it (`engine.ts`).
 */

import type { History, Live, Probe, Rows, Scene, Touches, Window, Worst } from "../protocol";

export interface Source {
  /** Whether numbers are in double precision, or rounded to 7 digits in the page. */
  readonly exact: boolean;
  /** Whether the source is a running machine. */
  readonly live: boolean;
  /** Whether a server answers requests. */
  readonly served: boolean;
  scene(run: number): Promise<Scene>;
  /** Rows of `count` frames from number `first`, one in `every`. */
  rows(run: number, first: number, count: number, every: number): Promise<Rows>;
  /** Points at which bodies touch at `count` frames from number `first`. */
  touches(run: number, first: number, count: number): Promise<Touches>;
  /** Frames of another time window of a long run; later row numbers refer to it. */
  window(run: number, start: number, end: number): Promise<Window>;
  probe(run: number, body: number, vertex: number, time: number): Promise<Probe>;
  /** Histories at a vertex; `of`: measures, `s11`, `ux`, `x`, `damage` and the like. */
  history(run: number, body: number, vertex: number, of: string[], most: number): Promise<History>;
  sensor(run: number, names: string[], most: number): Promise<History>;
  worst(run: number, measure: string, count: number): Promise<Worst[]>;
  extent(run: number, measure: string): Promise<[number, number]>;
  /** Commands to a running machine: `{do: "play"}` and others. */
  order(order: Record<string, unknown>): Promise<void>;
  /** Subscribe to the states of a running machine; returns the function that unsubscribes. */
  onLive(call: (live: Live) => void): () => void;
}
