/** Machine that runs inside the page, with the commands of a server. */

import type { Block, History, Live, Probe, Rows, Scene, Touches, Window, Worst } from "../protocol";
import { decode } from "../protocol";
import { Machine, STOPPED } from "./machine";
import * as numbers from "./numbers";
import type { Source } from "./source";

/** Data of a machine in a page. */
interface Stored {
  kind: "machine";
  scene: Scene;
  code: Block<Uint8Array>;
  /** Numbers of positions and of sensor values. */
  nq: number;
  nout: number;
  /** Fixed step of the method, s, and the number of steps per call. */
  step: number;
  every: number;
  events: string[];
  damages: { name: string; place: number }[];
}

/** Whether the data of a page describe a machine. */
export function isMachine(content: ArrayBuffer): boolean {
  return decode(content)["kind"] === "machine";
}

const BUDGET = 14; // time, ms, that steps may take between two pictures; or half of the time between them
const BEHIND = 250; // lag, ms, beyond which the engine does not catch up

export class EngineSource implements Source {
  readonly exact = false;
  readonly live = true;
  readonly served = false;
  private playing = false;
  private speed = 1;
  private due = 0;
  private last: number | null = null;
  private message = "";
  private longest = 0;
  private marks: { watch: number; time: number }[] = [];
  private values: number[];
  private changed = new Map<number, number>();
  private row: Float64Array;
  private listeners = new Set<(live: Live) => void>();

  constructor(
    private file: Stored,
    readonly machine: Machine,
  ) {
    this.values = (file.scene.inputs ?? []).map((input) => input.value);
    this.row = machine.positions();
  }

  static async open(content: ArrayBuffer): Promise<EngineSource> {
    const file = decode(content) as unknown as Stored;
    return new EngineSource(file, await Machine.open(file.code, file.nq, file.nout));
  }

  async scene(): Promise<Scene> {
    return this.file.scene;
  }

  async rows(_run: number, first: number, _count: number, every: number): Promise<Rows> {
    const time = Float64Array.of(this.machine.time);
    return {
      kind: "rows",
      first,
      every,
      time: { type: "f8", shape: [1], data: time },
      rows: { type: "f8", shape: [1, this.row.length], data: this.row.slice() },
    };
  }

  async touches(): Promise<Touches> {
    throw new Error("A machine in a page computes no contact forces; jousto live does.");
  }

  async window(_run: number, start: number, end: number): Promise<Window> {
    return { kind: "window", frames: this.file.scene.frames, window: [start, end] };
  }

  async probe(_run: number, body: number, vertex: number): Promise<Probe> {
    return numbers.probe(this.file.scene, this.row, body, vertex);
  }

  async history(_run: number, body: number, vertex: number, of: string[], most: number): Promise<History> {
    return numbers.history(this.file.scene, this.instant(), this.row, body, vertex, of, most);
  }

  async sensor(_run: number, names: string[], most: number): Promise<History> {
    return numbers.sensor(this.file.scene, undefined, names, most);
  }

  async worst(_run: number, measure: string, count: number): Promise<Worst[]> {
    return numbers.worst(this.file.scene, this.instant(), this.row, measure, count);
  }

  async extent(_run: number, measure: string): Promise<[number, number]> {
    return numbers.extent(this.file.scene, this.instant(), this.row, measure);
  }

  async order(order: Record<string, unknown>): Promise<void> {
    const { name } = order as { name?: string };
    const value = order["value"] as number;
    switch (order["do"]) {
      case "play":
        this.playing = true;
        this.message = "";
        this.last = null;
        requestAnimationFrame(this.tick);
        break;
      case "pause":
        this.playing = false;
        break;
      case "step":
        this.playing = false;
        this.message = "";
        this.advance();
        break;
      case "reset":
        this.reset();
        break;
      case "set":
        this.set(name!, value);
        return;
      case "parameter":
        this.change(name!, value);
        break;
      case "speed":
        this.speed = value;
        return;
      default:
        throw new Error("A machine in a page can be run and steered; jousto live also pulls and records.");
    }
    this.tell();
  }

  onLive(call: (live: Live) => void): () => void {
    this.listeners.add(call);
    queueMicrotask(() => this.listeners.has(call) && call(this.picture()));
    return () => this.listeners.delete(call);
  }

  private instant(): Float64Array {
    return Float64Array.of(this.machine.time);
  }

  private set(name: string, value: number): void {
    const k = (this.file.scene.inputs ?? []).findIndex((input) => input.name === name);
    if (k < 0 || !this.machine.input(k, value)) throw new Error(`Input ${name} cannot be ${value}.`);
    this.values[k] = value;
  }

  private change(name: string, value: number): void {
    const k = (this.file.scene.parameters ?? []).findIndex((parameter) => parameter.name === name);
    if (k < 0 || !this.machine.parameter(k, value)) throw new Error(`Parameter ${name} cannot be ${value}.`);
    this.changed.set(k, value);
  }

  /** Return to the start; inputs and parameters keep their values. */
  private reset(): void {
    this.machine.reset();
    this.changed.forEach((value, k) => this.machine.parameter(k, value));
    this.values.forEach((value, k) => this.machine.input(k, value));
    this.message = "";
    this.marks = [];
    this.due = this.longest = 0;
    this.row = this.machine.positions();
  }

  /** Advance by one interval; returns whether the run can continue. */
  private advance(): boolean {
    const before = performance.now();
    const status = this.machine.advance(this.file.every);
    this.longest = Math.max(this.longest, (performance.now() - before) / 1000 / this.file.every);
    this.row = this.machine.positions();
    if (status === STOPPED) this.message = `Stopped by ${this.file.events[this.machine.stopper] ?? "an event"}.`;
    else if (status) this.message = `The motion diverges at ${this.machine.time.toPrecision(4)} s: go back to the start.`;
    if (status) this.playing = false;
    return !status;
  }

  private tick = (now: number): void => {
    if (!this.playing) return;
    const { step, every } = this.file, interval = step * every;
    const passed = this.last === null ? 0 : Math.min(BEHIND, now - this.last);
    this.last = now;
    this.due += (this.speed * passed) / 1000;
    const until = performance.now() + Math.max(BUDGET, passed / 2);
    while (this.playing && (this.speed === 0 || this.due >= interval) && performance.now() < until) {
      this.due -= interval;
      this.advance();
    }
    if (this.speed === 0 || this.due > (this.speed * BEHIND) / 1000) this.due = 0;
    this.marks = [...this.marks.filter(({ watch }) => now - watch < 1000), { watch: now, time: this.machine.time }];
    this.tell();
    requestAnimationFrame(this.tick);
  };

  private tell(): void {
    const picture = this.picture();
    for (const call of [...this.listeners]) call(picture);
  }

  private picture(): Live {
    const sensors = this.machine.outputs() ?? new Float64Array(this.file.nout).fill(NaN);
    const [first] = this.marks, last = this.marks.at(-1);
    const passed = first && last ? (last.watch - first.watch) / 1000 : 0;
    return {
      kind: "live",
      time: this.machine.time,
      row: { type: "f8", shape: [this.row.length], data: this.row },
      sensors: { type: "f8", shape: [sensors.length], data: sensors },
      factor: passed > 0 ? (last!.time - first.time) / passed : 0,
      worst: this.longest,
      late: [],
      damage: this.file.damages.map(({ name, place }) => ({ name, value: sensors[place] })),
      playing: this.playing,
      recording: null,
      message: this.message,
    };
  }
}
