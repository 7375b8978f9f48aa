/** Container of scenes and answers, and its content. */

export type Numbers = Float64Array | Float32Array | Uint32Array | Int32Array | Uint16Array | Uint8Array;
export type Kind = "f8" | "f4" | "f2" | "u4" | "i4" | "u2" | "u1";

/** Array of a container in C order. Half floats ("f2") remain 16-bit integers. */
export interface Block<T extends Numbers = Numbers> {
  type: Kind;
  shape: number[];
  data: T;
}

export type Vec3 = [number, number, number];
export type Quat = [number, number, number, number];

/** Point on a body: `R + A (u + s phi p)`; `place` is -1 in the world. */
export interface Side {
  place: number;
  n: number;
  u: Vec3;
  phi: Block<Float64Array> | null;
  frame: Quat;
}

/** Exact beam: rings of its sections between the end poses of its elements. */
/** Vertices of a beam or frame by sections along its elements. */
export interface Sections {
  element: Block<Uint32Array>;
  share: Block<Float64Array>;
  vertex_ring: Block<Uint32Array>;
  yz: Block<Float32Array>;
}

export interface Rings extends Sections {
  places: Block<Uint32Array>;
  ends: Block<Float64Array>;
  /** Original `yz`, m, where thin sections are drawn thicker. */
  section?: Float32Array;
  forces: number;
  corner: Block<Uint16Array>;
  rows: Block<Float64Array>;
  least: number;
}

export interface Body {
  name: string;
  /** "contact": shapes that touch. */
  kind: "solid" | "frame" | "beam" | "rigid" | "ground" | "mesh" | "contact";
  place: number;
  modes: number;
  positions: Block<Float32Array>;
  triangles: Block<Uint32Array> | null;
  lines: Block<Uint32Array> | null;
  edges: Block<Uint32Array> | null;
  shapes: Block<Uint16Array | Float32Array> | null;
  shape_scale?: number[];
  stress: Block<Uint16Array | Float32Array> | null;
  stress_scale?: number[];
  static: Block<Float32Array> | null;
  known: Block<Uint8Array> | null;
  nodes: Block<Uint32Array> | null;
  damage: Block<Float32Array> | null;
  /** s; infinite if unlimited. */
  life: Block<Float32Array> | null;
  mass: number | null;
  about: string;
  rings: Rings | null;
  sections: Sections | null;
}

export interface Symbol {
  name: string;
  kind: string;
  group: "joint" | "force" | "sensor" | "ground";
  sides: Side[];
  axis: Vec3 | null;
  /** Whether the axis is fixed in the world instead of on the first body. */
  fixed?: boolean;
  size: number | null;
  sensor: string | null;
  text: string;
  cylinder?: Cylinder | null;
}

/** Sizes of a hydraulic cylinder, m, and the sensors of the pressures on the piston and the rod side. */
export interface Cylinder {
  bore: number;
  rod: number;
  closed: number;
  stroke: number;
  pressures: [string, string];
}

export interface Sensor {
  name: string;
  unit: string;
  units: string[];
  components: string[];
  description: string;
  side: Side | null;
  arrow: "force" | "moment" | "velocity" | "acceleration" | null;
  columns: number[] | null;
  /** Magnitude of each component below which a reading is rounding error. */
  floors: number[];
}

export interface Mode {
  label: string;
  frequency: number;
  damping: number | null;
  real: Block<Float64Array>;
  imag: Block<Float64Array> | null;
  amplitude: number;
  note: string;
}

export interface Input {
  name: string;
  unit: string;
  low: number;
  high: number;
  value: number;
}

export interface Parameter {
  name: string;
  value: number;
  unit: string;
  low: number | null;
  high: number | null;
}

export interface Scene {
  kind: "scene";
  version: number;
  what: "run" | "model" | "part" | "modes" | "live";
  name: string;
  title: string;
  up: Vec3;
  gravity: Vec3 | null;
  box: [Vec3, Vec3];
  row: number;
  still: Block<Float64Array>;
  frames: Block<Float64Array>;
  window: [number, number];
  thinned?: number;
  bodies: Body[];
  symbols: Symbol[];
  markers: { name: string; side: Side }[];
  sensors: Sensor[];
  inputs?: Input[];
  modes?: Mode[];
  events?: { time: number; name: string }[];
  measures: string[];
  limits: Record<string, [number, number] | null>;
  parameters?: Parameter[];
  runs?: string[];
  /** Largest normal force of the contacts, N, 0 if not known; null without contacts. */
  touches: number | null;
  /** Note on the run for the user, for example that it is unfinished. */
  note?: string;
}

export interface Rows {
  kind: "rows";
  first: number;
  every: number;
  time: Block<Float64Array>;
  rows: Block<Float32Array | Float64Array>;
}

/** Points at which bodies touch at some instants: their numbers, 13 values each and their texts. */
export interface Touches {
  counts: Block<Uint32Array>;
  values: Block<Float32Array | Float64Array>;
  texts: string[];
}

export interface Window {
  kind: "window";
  frames: Block<Float64Array>;
  window: [number, number];
  thinned?: number;
}

export interface Probe {
  node: number;
  position: Vec3;
  displacement: Vec3;
  stress: number[] | null;
  "von-mises": number | null;
  principal: Vec3 | null;
  damage: number | null;
  life: number | null;
}

/** Histories: `values` is (number of labels, number of instants). */
export interface History {
  time: Block<Float64Array>;
  values: Block<Float64Array>;
  units: string[];
  labels?: string[];
}

export interface Worst {
  body: number;
  vertex: number;
  position: Vec3;
  value: number;
  time: number | null;
  label: string;
}

export interface Live {
  kind: "live";
  time: number;
  row: Block<Float32Array | Float64Array>;
  sensors: Block<Float64Array>;
  factor: number;
  worst: number;
  late: number[];
  damage: { name: string; value: number }[];
  playing: boolean;
  recording: string | null;
  message: string;
  /** Points at which bodies touch, of machines with contacts. */
  touches?: Touches;
  /** Version of the scene, increased by each parameter change. */
  scene?: number;
}

export interface Failure {
  id: number;
  kind: "error";
  message: string;
  /** Whether the files have new content. */
  renewed?: boolean;
}

const MAGIC = "JOV1";
const SIZES: Record<Kind, number> = { f8: 8, f4: 4, f2: 2, u4: 4, i4: 4, u2: 2, u1: 1 };

function numbers(kind: Kind, buffer: ArrayBuffer, at: number, count: number): Numbers {
  switch (kind) {
    case "f8":
      return new Float64Array(buffer, at, count);
    case "f4":
      return new Float32Array(buffer, at, count);
    case "u4":
      return new Uint32Array(buffer, at, count);
    case "i4":
      return new Int32Array(buffer, at, count);
    case "f2":
    case "u2":
      return new Uint16Array(buffer, at, count);
    case "u1":
      return new Uint8Array(buffer, at, count);
  }
}

function isReference(value: object): value is { at: number; shape: number[]; type: Kind } {
  return "at" in value && "shape" in value && "type" in value;
}

/** Decode a container: its header with references replaced by their `Block`. */
export function decode(buffer: ArrayBuffer): Record<string, unknown> {
  const view = new DataView(buffer);
  if (buffer.byteLength < 8 || new TextDecoder().decode(new Uint8Array(buffer, 0, 4)) !== MAGIC) {
    throw new Error("These data are not a container of jousto.");
  }
  const length = view.getUint32(4, true);
  const start = 8 + length;
  if (start > buffer.byteLength) throw new Error("The container ends within its header.");
  const header: unknown = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 8, length)));
  const fill = (value: unknown): unknown => {
    if (Array.isArray(value)) return value.map(fill);
    if (value === null || typeof value !== "object") return value;
    if (isReference(value)) {
      const count = value.shape.reduce((a, b) => a * b, 1);
      const at = start + value.at;
      if (!(value.type in SIZES) || at + count * SIZES[value.type] > buffer.byteLength) {
        throw new Error(`The container ends within an array of ${value.shape.join(" x ")}.`);
      }
      return { type: value.type, shape: value.shape, data: numbers(value.type, buffer, at, count) };
    }
    return Object.fromEntries(Object.entries(value).map(([key, entry]) => [key, fill(entry)]));
  };
  return fill(header) as Record<string, unknown>;
}

/** Return the value of a half float from its 16 bits. */
export function half(bits: number): number {
  const sign = bits & 0x8000 ? -1 : 1;
  const exponent = (bits >> 10) & 0x1f;
  const fraction = bits & 0x3ff;
  if (exponent === 0) return sign * fraction * 2 ** -24;
  if (exponent === 31) return fraction ? NaN : sign * Infinity;
  return sign * (1 + fraction / 1024) * 2 ** (exponent - 15);
}
