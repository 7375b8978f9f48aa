import assert from "node:assert/strict";
import { test } from "node:test";
import type { Scene, Side, Symbol, Vec3 } from "../src/protocol";
import { sizesOf } from "../src/render/symbols/sizes";

const at = (place: number, u: Vec3): Side => ({ place, n: 0, u, phi: null, frame: [1, 0, 0, 0] });

const symbol = (sides: Side[], group: Symbol["group"] = "joint"): Symbol =>
  ({ name: "", kind: "revolute", group, sides, axis: null, size: null, sensor: null, text: "" });

/** A chain of links of 1 m from the ground on, along x, each 7 numbers of the row further. */
function chain(links: number): { scene: Scene; row: Float64Array } {
  const row = new Float64Array(7 * links);
  const symbols = [];
  for (let i = 0; i < links; i++) {
    row.set([i, 0, 0, 1, 0, 0, 0], 7 * i);
    symbols.push(symbol([i ? at(7 * (i - 1), [1, 0, 0]) : at(-1, [0, 0, 0]), at(7 * i, [0, 0, 0])]));
  }
  return { scene: { symbols } as unknown as Scene, row };
}

test("joints of many short links are smaller than the links", () => {
  const { scene, row } = chain(200);
  // a pin is 2.4 sizes long, a ring 1.5 wide: more than half of the link is seen
  const sizes = sizesOf(scene, row, 100);
  for (const size of sizes) assert.ok(size > 0.1 && size <= 0.25, `${size}`);
});

test("joints of a few long links have the size of the machine", () => {
  const { scene, row } = chain(4);
  for (const size of sizesOf(scene, row, 2)) assert.equal(size, 0.056);
});

test("several joints at one place, and a near one, do not make each other vanish", () => {
  const three = [0, 7, 14].map((place) => symbol([at(-1, [0, 0, 0]), at(place, [0, 0, 0])]));
  const near = symbol([at(-1, [1e-5, 0, 0]), at(21, [0, 0, 0])]);
  const scene = { symbols: [...three, near] } as unknown as Scene;
  for (const size of sizesOf(scene, new Float64Array(28), 1)) assert.ok(size >= 0.0028 * (1 - 1e-12));
});

test("a short spring is thin, a sensor makes no joint smaller", () => {
  const row = new Float64Array([0, 0, 0, 1, 0, 0, 0, 0.1, 0, 0, 1, 0, 0, 0]);
  const spring = symbol([at(0, [0, 0, 0]), at(7, [0, 0, 0])], "force");
  const joint = symbol([at(-1, [0, 0, 0]), at(0, [0, 0, 0])]);
  const sensor = symbol([at(0, [0.01, 0, 0])], "sensor");
  const [thin, usual] = sizesOf({ symbols: [spring, joint, sensor] } as unknown as Scene, row, 10);
  assert.equal(thin, 0.028 * 10 * 0.1);
  assert.equal(usual, 0.28);
});
