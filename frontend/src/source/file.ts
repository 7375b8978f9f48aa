/** Scenes and numbers from data inside the page. */

import { before } from "../motion/track";
import type { Block, History, Live, Probe, Rows, Scene, Touches, Window, Worst } from "../protocol";
import { decode } from "../protocol";
import * as numbers from "./numbers";
import type { Source } from "./source";

/** Data of a run in a page. */
export interface Stored {
  scene: Scene;
  time: Block<Float64Array>;
  rows: Block<Float32Array | Float64Array>;
  sensors?: numbers.Sensors;
  touches?: Touches;
  worst?: Worst[] | Record<string, Worst[]>;
}

/** Unpack base64 of a gzip stream. */
export async function unpack(text: string): Promise<ArrayBuffer> {
  const binary = atob(text.trim());
  const bytes = new Uint8Array(binary.length);
  for (let i = 0; i < binary.length; i++) bytes[i] = binary.charCodeAt(i);
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Response(stream).arrayBuffer();
}

export class FileSource implements Source {
  readonly exact = false;
  readonly live = false;
  readonly served = false;
  private runs: Stored[];

  constructor(content: ArrayBuffer) {
    const file = decode(content) as unknown as Stored & { runs?: Stored[] };
    this.runs = file.runs ?? [file];
  }

  async scene(run: number): Promise<Scene> {
    return this.runs[run].scene;
  }

  async rows(run: number, first: number, count: number, every: number): Promise<Rows> {
    const { time, rows } = this.runs[run];
    const nr = rows.shape[1], last = Math.min(time.data.length, first + count * every);
    if (every === 1) {
      const times = time.data.subarray(first, last);
      const part = rows.data.subarray(first * nr, last * nr);
      return answer(first, every, times, part, nr, rows.type);
    }
    const chosen: number[] = [];
    for (let i = first; i < last; i += every) chosen.push(i);
    const part = new Float64Array(chosen.length * nr);
    chosen.forEach((i, k) => part.set(rows.data.subarray(i * nr, (i + 1) * nr), k * nr));
    return answer(first, every, Float64Array.from(chosen, (i) => time.data[i]), part, nr, "f8");
  }

  async touches(run: number, first: number, count: number): Promise<Touches> {
    const { touches } = this.runs[run];
    if (!touches) throw new Error("This page contains no contact forces.");
    const { counts, values, texts } = touches, width = values.shape[1];
    const sum = (end: number): number => counts.data.subarray(0, end).reduce((a, b) => a + b, 0);
    const data = values.data.subarray(width * sum(first), width * sum(first + count));
    return {
      counts: { type: "u4", shape: [count], data: counts.data.subarray(first, first + count) },
      values: { type: values.type, shape: [data.length / width, width], data },
      texts,
    };
  }

  async window(run: number, start: number, end: number): Promise<Window> {
    // the page contains all frames: every window has the same ones
    const { time } = this.runs[run];
    return { kind: "window", frames: time, window: [start, end] };
  }

  async probe(run: number, body: number, vertex: number, time: number): Promise<Probe> {
    const { scene } = this.runs[run];
    return numbers.probe(scene, this.row(run, time), body, vertex);
  }

  async history(run: number, body: number, vertex: number, of: string[], most: number): Promise<History> {
    const { scene, time, rows } = this.runs[run];
    return numbers.history(scene, time.data, rows.data, body, vertex, of, most);
  }

  async sensor(run: number, names: string[], most: number): Promise<History> {
    const { scene, sensors } = this.runs[run];
    return numbers.sensor(scene, sensors, names, most);
  }

  async worst(run: number, measure: string, count: number): Promise<Worst[]> {
    const { scene, time, rows, worst } = this.runs[run];
    const known = Array.isArray(worst) ? (measure === "von-mises" ? worst : undefined) : worst?.[measure];
    return known?.slice(0, count) ?? numbers.worst(scene, time.data, rows.data, measure, count);
  }

  async extent(run: number, measure: string): Promise<[number, number]> {
    const { scene, time, rows } = this.runs[run];
    return scene.limits[measure] ?? numbers.extent(scene, time.data, rows.data, measure);
  }

  order(): Promise<void> {
    return Promise.reject(new Error("No machine runs behind this page."));
  }

  onLive(_call: (live: Live) => void): () => void {
    return () => undefined;
  }

  private row(run: number, time: number): ArrayLike<number> {
    const { scene, time: times, rows } = this.runs[run];
    if (!times.data.length) return scene.still.data;
    const i = before(times.data, time), nr = rows.shape[1];
    const next = Math.min(i + 1, times.data.length - 1);
    const nearer = Math.abs(times.data[next] - time) < Math.abs(times.data[i] - time) ? next : i;
    return rows.data.subarray(nearer * nr, (nearer + 1) * nr);
  }
}

function answer(
  first: number,
  every: number,
  time: Float64Array,
  rows: Float32Array | Float64Array,
  nr: number,
  type: Block["type"],
): Rows {
  return {
    kind: "rows",
    first,
    every,
    time: { type: "f8", shape: [time.length], data: time },
    rows: { type, shape: [time.length, nr], data: rows },
  };
}
