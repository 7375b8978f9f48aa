/** Sizes of symbols from the machine's size and the distance to other symbols on the same body. */

import { sidePosition } from "../../motion/pose";
import type { Scene, Symbol, Vec3 } from "../../protocol";

const USUAL = 0.028; // usual size, relative to the radius of the machine
const SHARE = 0.25; // largest size, relative to the distance to the next symbol: rings are 1.5 sizes wide, pins 2.4 long
const LEAST = 0.1; // smallest size, relative to the usual size, if only one other symbol is near: both may be meant to be at one place
const SAME = 1e-9; // distance, relative to the radius of the machine, below which two symbols are at one place

/** Distances to the two nearest joints, and the index of the nearest one. */
interface Near {
  next: number;
  second: number;
  which: number;
}

/** Sizes of the symbols of a scene, m; lengths of forces are those of a row. */
export function sizesOf(scene: Scene, row: ArrayLike<number>, radius: number): number[] {
  const usual = USUAL * radius;
  const near = nextOnBodies(scene.symbols, SAME * radius);
  const sizes = scene.symbols.map((symbol, i) => {
    if (symbol.size !== null) return symbol.size;
    const { next, second } = near[i];
    const span = symbol.group === "force" ? lengthOf(symbol, row) : 0;
    const most = span > SAME * radius ? Math.max(SHARE * span, LEAST * usual) : usual;
    return Math.min(usual, most, SHARE * second, Math.max(SHARE * next, LEAST * usual));
  });
  // the last symbol of a chain has the size of the previous one
  return sizes.map((size, i) => Math.min(size, scene.symbols[i].size === null ? (sizes[near[i].which] ?? size) : size));
}

/** Distance between the ends of a symbol. */
function lengthOf(symbol: Symbol, row: ArrayLike<number>): number {
  if (symbol.sides.length < 2) return 0;
  const [a, b] = [symbol.sides[0], symbol.sides[symbol.sides.length - 1]].map((side) => [...sidePosition(side, row)]);
  return Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

/** Distances of each symbol to the two nearest joints at other points of the same body. */
function nextOnBodies(symbols: readonly Symbol[], same: number): Near[] {
  const out = symbols.map((): Near => ({ next: Infinity, second: Infinity, which: -1 }));
  const bodies = new Map<number, { symbol: number; u: Vec3; joint: boolean }[]>();
  symbols.forEach((symbol, i) => {
    for (const { place, u } of symbol.sides) {
      if (!bodies.has(place)) bodies.set(place, []);
      bodies.get(place)!.push({ symbol: i, u, joint: symbol.group === "joint" });
    }
  });
  for (const points of bodies.values()) {
    // sweep along the longest side: stop beyond the second nearest joint
    const spread = [0, 1, 2].map((k) => bounds(points, k)).map(([low, high]) => high - low);
    const k = spread.indexOf(Math.max(...spread));
    points.sort((a, b) => a.u[k] - b.u[k]);
    points.forEach(({ symbol, u }, i) => {
      const found: { at: Vec3; d: number; other: number }[] = [];
      for (const step of [1, -1]) {
        for (let j = i + step; j >= 0 && j < points.length; j += step) {
          const { u: at, joint, symbol: other } = points[j];
          if (found.length > 1 && Math.abs(at[k] - u[k]) > found[1].d) break;
          const d = distance(at, u);
          if (!joint || other === symbol || d <= same || found.some((one) => distance(one.at, at) <= same)) continue;
          found.push({ at, d, other });
          found.sort((a, b) => a.d - b.d).splice(2);
        }
      }
      const one = out[symbol];
      if (found.length && found[0].d < one.next) one.which = found[0].other;
      [one.next, one.second] = [one.next, one.second, ...found.map(({ d }) => d)].sort((a, b) => a - b);
    });
  }
  return out;
}

function bounds(points: { u: Vec3 }[], k: number): [number, number] {
  return points.reduce<[number, number]>(([low, high], { u }) => [Math.min(low, u[k]), Math.max(high, u[k])], [Infinity, -Infinity]);
}

const distance = (a: Vec3, b: Vec3): number => Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
