/** Joints of a static machine: rotation or translation of the bodies beyond a joint. */

import { exponential, turn } from "../math/rotation";
import type { Scene, Side, Symbol } from "../protocol";
import { sideAxes, sidePosition } from "./pose";

/*Freedom of a joint of which one side has no other connection. */
export interface Freedom {
  name: string;
  /** Whether it is a rotation, rad; else a translation, m. */
  turns: boolean;
  symbol: Symbol;
  /** 1 if the second side moves, -1 if the first side moves. */
  sign: 1 | -1;
  /** Columns of the row with the poses of the moved bodies. */
  places: readonly number[];
}

const TURNS = new Set(["revolute", "cylindrical"]);
const SHIFTS = new Set(["prismatic", "cylindrical"]);
const DRIVES = new Set(["motor", "actuator"]); // these act along a joint and connect no bodies

interface Edge {
  ends: [number, number];
  symbol: Symbol | null;
}

/**
 * Freedoms that can be set one by one: those of joints that are not part of a closed loop of bodies. These are the
 * bridges of the graph of bodies and joints (Tarjan, Information Processing Letters 2, 1974).
 */
export function freedoms(scene: Scene): Freedom[] {
  const edges = edgesOf(scene);
  const at = new Map<number, number[]>([[-1, []]]);
  edges.forEach(({ ends }, k) => {
    for (const place of ends) {
      const there = at.get(place);
      if (there) there.push(k);
      else at.set(place, [k]);
    }
  });
  const order: number[] = []; // places in the order in which they are reached
  const reached = new Map<number, number>();
  const found: { edge: Edge; child: number; from: number; to: number }[] = [];
  for (const root of at.keys()) {
    if (reached.has(root)) continue;
    const path = [{ place: root, by: -1, next: 0, lowest: order.length }];
    reached.set(root, order.push(root) - 1);
    while (path.length) {
      const here = path[path.length - 1];
      const k = at.get(here.place)![here.next++];
      if (k === undefined) {
        path.pop();
        if (!path.length) break;
        const parent = path[path.length - 1], first = reached.get(here.place)!;
        parent.lowest = Math.min(parent.lowest, here.lowest);
        if (here.lowest >= first) found.push({ edge: edges[here.by], child: here.place, from: first, to: order.length });
        continue;
      }
      if (k === here.by) continue;
      const [a, b] = edges[k].ends;
      const there = a === here.place ? b : a;
      const known = reached.get(there);
      if (known !== undefined) here.lowest = Math.min(here.lowest, known);
      else {
        path.push({ place: there, by: k, next: 0, lowest: order.length });
        reached.set(there, order.push(there) - 1);
      }
    }
  }
  const bridges = new Map(found.map((bridge) => [bridge.edge.symbol, bridge]));
  return scene.symbols.flatMap((symbol) => {
    const bridge = bridges.get(symbol);
    if (!bridge || !symbol.axis) return [];
    const sign = bridge.child === symbol.sides[1].place ? 1 : -1;
    const places = order.slice(bridge.from, bridge.to);
    const both = TURNS.has(symbol.kind) && SHIFTS.has(symbol.kind);
    return [true, false]
      .filter((turns) => (turns ? TURNS : SHIFTS).has(symbol.kind))
      .map((turns) => ({ name: both ? `${symbol.name}, ${turns ? "turn" : "shift"}` : symbol.name, turns, symbol, sign, places }) as Freedom);
  });
}

/** Set freedoms to values, rad or m, relative to the pose of a row, which is changed in place. */
export function setFreedoms(all: readonly Freedom[], values: readonly number[], row: Float64Array): Float64Array {
  all.forEach((freedom, k) => values[k] && move(freedom, values[k], row));
  return row;
}

function move({ symbol, turns, sign, places }: Freedom, value: number, row: Float64Array): void {
  const [first] = symbol.sides as [Side];
  const n = new Float64Array(3), c = new Float64Array(3), x = new Float64Array(3);
  if (symbol.fixed) n.set(symbol.axis!);
  else turn(sideAxes(first, row), ...symbol.axis!, n);
  const scale = (sign * value) / Math.hypot(...n);
  for (let i = 0; i < 3; i++) n[i] *= scale;
  if (!turns) {
    for (const at of places) for (let i = 0; i < 3; i++) row[at + i] += n[i];
    return;
  }
  sidePosition(first, row, 1, c);
  const R = exponential(n);
  const half = Math.abs(value) / 2, s = Math.sin(half) / Math.abs(value);
  const [a, b, d, e] = [Math.cos(half), s * n[0], s * n[1], s * n[2]];
  for (const at of places) {
    turn(R, row[at] - c[0], row[at + 1] - c[1], row[at + 2] - c[2], x);
    for (let i = 0; i < 3; i++) row[at + i] = c[i] + x[i];
    const [p, q, u, v] = row.subarray(at + 3, at + 7);
    row[at + 3] = a * p - b * q - d * u - e * v;
    row[at + 4] = a * q + b * p + d * v - e * u;
    row[at + 5] = a * u - b * v + d * p + e * q;
    row[at + 6] = a * v + b * u - d * q + e * p;
  }
}

/** Connections between places: joints, couplings, and beams between their nodes. */
function edgesOf(scene: Scene): Edge[] {
  const chain = (places: ArrayLike<number>, symbol: Symbol | null): Edge[] =>
    Array.from({ length: places.length - 1 }, (_, k): Edge => ({ ends: [places[k], places[k + 1]], symbol })).filter(
      ({ ends: [a, b] }) => a !== b,
    );
  return [
    ...scene.bodies.flatMap(({ rings }) => (rings ? chain(rings.places.data, null) : [])),
    ...scene.symbols.flatMap((symbol) => {
      if (symbol.group !== "joint" || DRIVES.has(symbol.kind)) return [];
      return chain(symbol.sides.map(({ place }) => place), symbol.sides.length === 2 ? symbol : null);
    }),
  ];
}
