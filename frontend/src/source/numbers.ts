/**
 * Numbers that a page without a server computes itself, in double precision from the data in the page (5 digits): the present stress of a
 * point, its history, ranges over the run and worst places.
 */

import { measure, principal, vonMises } from "../math/tensor";
import { displacement, position, stress } from "../motion/pose";
import type { Block, Body, History, Numbers, Probe, Scene, Vec3, Worst } from "../protocol";

type Series = Float64Array | Float32Array;

/** Sensor curves, each (components, instants). */
export interface Sensors {
  time: Block<Float64Array>;
  values: Record<string, Block<Float32Array | Float64Array>>;
}

const block = <T extends Numbers>(data: T, shape: number[]): Block<T> => ({ type: "f8", shape, data });

/** All values at a vertex in one row. */
export function probe(scene: Scene, row: ArrayLike<number>, body: number, vertex: number): Probe {
  const at = scene.bodies[body];
  const s = stress(at, vertex, row);
  const damage = at.damage ? at.damage.data[vertex] : null;
  return {
    node: at.nodes ? at.nodes.data[vertex] : vertex + 1,
    position: Array.from(position(at, vertex, row)) as Vec3,
    displacement: (at.rings ? [NaN, NaN, NaN] : Array.from(displacement(at, vertex, row))) as Vec3,
    stress: s && Array.from(s),
    "von-mises": s && vonMises(s),
    principal: s && principal(s),
    damage,
    life: at.life && Number.isFinite(at.life.data[vertex]) ? at.life.data[vertex] : null,
  };
}

const POSITIONS = ["x", "y", "z"];
const SHIFTS = ["ux", "uy", "uz"];

/** Value at a vertex in one row by its name; NaN where unknown. */
export function value(name: string, body: Body, vertex: number, row: ArrayLike<number>): number {
  if (POSITIONS.includes(name)) return position(body, vertex, row)[POSITIONS.indexOf(name)];
  if (name === "damage") return body.damage ? body.damage.data[vertex] : NaN;
  if (name === "displacement" || SHIFTS.includes(name)) {
    if (body.rings) return NaN;
    const u = displacement(body, vertex, row);
    return name === "displacement" ? Math.hypot(u[0], u[1], u[2]) : u[SHIFTS.indexOf(name)];
  }
  const s = stress(body, vertex, row);
  return s ? measure(name, s) : NaN;
}

export function unit(name: string): string {
  if (POSITIONS.includes(name) || SHIFTS.includes(name) || name === "displacement") return "m";
  return name === "damage" ? "1" : name === "life" ? "s" : "Pa";
}

/** Histories at a vertex, thinned to the extremes of intervals above `most` instants. */
export function history(
  scene: Scene,
  time: ArrayLike<number>,
  rows: Series,
  body: number,
  vertex: number,
  of: readonly string[],
  most: number,
): History {
  const nr = scene.row;
  const series = of.map((name) => {
    const out = new Float64Array(time.length);
    for (let i = 0; i < time.length; i++) {
      out[i] = value(name, scene.bodies[body], vertex, rows.subarray(i * nr, (i + 1) * nr));
    }
    return out;
  });
  return { ...thinned(time, series, most), units: of.map(unit), labels: [...of] };
}

/** Sensor curves, one per component. */
export function sensor(scene: Scene, sensors: Sensors | undefined, names: readonly string[], most: number): History {
  const curves: ArrayLike<number>[] = [];
  const labels: string[] = [];
  const units: string[] = [];
  for (const name of names) {
    const values = sensors?.values[name];
    const known = scene.sensors.find((candidate) => candidate.name === name);
    if (!values || !known) throw new Error(`The values of the sensor ${name} are not in this page.`);
    const length = values.data.length / known.components.length;
    known.components.forEach((component, k) => {
      curves.push(values.data.subarray(k * length, (k + 1) * length));
      labels.push(known.components.length > 1 ? `${name} ${component}` : name);
      units.push(known.units[k] ?? known.unit);
    });
  }
  return { ...thinned(sensors!.time.data, curves, most), labels, units };
}

/** Curves thinned to `most` instants: the minimum and maximum of each interval. */
export function thinned(
  time: ArrayLike<number>,
  series: readonly ArrayLike<number>[],
  most: number,
): { time: Block<Float64Array>; values: Block<Float64Array> } {
  const keep = chosen(time.length, series, most);
  const values = new Float64Array(series.length * keep.length);
  series.forEach((curve, k) => keep.forEach((i, n) => (values[k * keep.length + n] = curve[i])));
  return {
    time: block(Float64Array.from(keep, (i) => time[i]), [keep.length]),
    values: block(values, [series.length, keep.length]),
  };
}

function chosen(n: number, series: readonly ArrayLike<number>[], most: number): number[] {
  const stretches = Math.max(1, Math.floor((most - 2) / (2 * Math.max(1, series.length))));
  if (n <= most) return Array.from({ length: n }, (_, i) => i);
  const keep = new Set([0, n - 1]);
  for (let k = 0; k < stretches; k++) {
    const from = Math.floor((k * n) / stretches);
    const to = Math.floor(((k + 1) * n) / stretches);
    for (const curve of series) {
      let low = -1;
      let high = -1;
      for (let i = from; i < to; i++) {
        if (Number.isNaN(curve[i])) continue;
        if (low < 0 || curve[i] < curve[low]) low = i;
        if (high < 0 || curve[i] > curve[high]) high = i;
      }
      if (low >= 0) keep.add(low).add(high);
    }
  }
  return [...keep].sort((a, b) => a - b);
}

/** Largest and smallest value of a measure at each place, over at most `INSTANTS` evenly spaced instants. */
const INSTANTS = 400;

function* everywhere(
  scene: Scene,
  time: ArrayLike<number>,
  rows: Series,
  name: string,
): Generator<{ body: number; vertex: number; value: number; instant: number }> {
  const stride = Math.max(1, Math.ceil(time.length / INSTANTS));
  for (let body = 0; body < scene.bodies.length; body++) {
    const at = scene.bodies[body];
    const still = name === "damage" || !(at.shapes || at.rings || at.stress);
    const count = at.positions.shape[0];
    for (let i = 0; i < (still ? Math.min(1, time.length) : time.length); i += stride) {
      const row = rows.subarray(i * scene.row, (i + 1) * scene.row);
      for (let vertex = 0; vertex < count; vertex++) {
        const found = value(name, at, vertex, row);
        if (!Number.isNaN(found)) yield { body, vertex, value: found, instant: i };
      }
    }
  }
}

/** Lowest and highest value of a measure over run and places; zeros if it is unknown everywhere. */
export function extent(scene: Scene, time: ArrayLike<number>, rows: Series, name: string): [number, number] {
  let low = Infinity;
  let high = -Infinity;
  for (const { value: found } of everywhere(scene, time, rows, name)) {
    if (found < low) low = found;
    if (found > high) high = found;
  }
  return low <= high ? [low, high] : [0, 0];
}

/** Places with the largest values, each a maximum of its surroundings (a tenth of its body). */
export function worst(
  scene: Scene,
  time: ArrayLike<number>,
  rows: Series,
  name: string,
  count: number,
): Worst[] {
  const best = scene.bodies.map((body) => new Float64Array(body.positions.shape[0]).fill(-Infinity));
  const when = scene.bodies.map((body) => new Uint32Array(body.positions.shape[0]));
  for (const { body, vertex, value: found, instant } of everywhere(scene, time, rows, name)) {
    if (Math.abs(found) > best[body][vertex]) {
      best[body][vertex] = Math.abs(found);
      when[body][vertex] = instant;
    }
  }
  const out: Worst[] = [];
  while (out.length < count) {
    const next = largest(best);
    if (!next) break;
    const [body, vertex] = next;
    const at = scene.bodies[body];
    const instant = when[body][vertex];
    const row = rows.subarray(instant * scene.row, (instant + 1) * scene.row);
    out.push({
      body,
      vertex,
      position: Array.from(position(at, vertex, row)) as Vec3,
      value: value(name, at, vertex, row),
      time: name === "damage" ? null : time[instant],
      label: `${at.name}, node ${at.nodes ? at.nodes.data[vertex] : vertex + 1}`,
    });
    clear(at, vertex, best[body]);
  }
  return out;
}

function largest(best: readonly Float64Array[]): [number, number] | null {
  let found: [number, number] | null = null;
  let high = 0;
  best.forEach((values, body) => {
    for (let vertex = 0; vertex < values.length; vertex++) {
      if (values[vertex] > high) {
        high = values[vertex];
        found = [body, vertex];
      }
    }
  });
  return found;
}

function clear(body: Body, vertex: number, values: Float64Array): void {
  const x = body.positions.data;
  const size = [0, 1, 2].map((axis) => {
    let low = Infinity;
    let high = -Infinity;
    for (let i = axis; i < x.length; i += 3) {
      low = Math.min(low, x[i]);
      high = Math.max(high, x[i]);
    }
    return high - low;
  });
  const near = 0.1 * Math.hypot(...size);
  for (let i = 0; i < values.length; i++) {
    const away = [0, 1, 2].map((axis) => x[3 * i + axis] - x[3 * vertex + axis]);
    if (Math.hypot(...away) <= near) values[i] = -Infinity;
  }
}
