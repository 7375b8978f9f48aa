import assert from "node:assert/strict";
import { test } from "node:test";
import { freedoms, setFreedoms } from "../src/motion/joints";
import { position } from "../src/motion/pose";
import type { Body, Quat, Scene, Side, Symbol, Vec3 } from "../src/protocol";

const side = (place: number, u: Vec3): Side => ({ place, n: 0, u, phi: null, frame: [1, 0, 0, 0] });
const joint = (name: string, kind: string, from: Side, to: Side, axis: Vec3): Symbol => ({
  name, kind, group: "joint", sides: [from, to], axis, size: null, sensor: null, text: "",
});
const scene = (symbols: Symbol[]): Scene => ({ symbols, bodies: [] }) as unknown as Scene;
const point = (place: number, x: Vec3): Body =>
  ({ place, modes: 0, shapes: null, rings: null, positions: { type: "f4", shape: [1, 3], data: new Float32Array(x) } }) as unknown as Body;

/** Bodies of unit length along x, one after the other, of which each is turned about its own x by an angle. */
function links(count: number, roll = 0): Float64Array {
  const e: Quat = [Math.cos(roll / 2), Math.sin(roll / 2), 0, 0];
  return Float64Array.from(Array.from({ length: count }, (_, k) => [k, 0, 0, ...e]).flat());
}
const close = (a: ArrayLike<number>, b: number[]): void =>
  // a few roundings of numbers near 1
  b.forEach((x, i) => assert.ok(Math.abs(a[i] - x) < 1e-14, `${i}: ${a[i]} is not ${x}`));

test("a plane arm of two turns: x = cos a + cos(a + b), y = sin a + sin(a + b)", () => {
  const arm = scene([
    joint("shoulder", "revolute", side(-1, [0, 0, 0]), side(0, [0, 0, 0]), [0, 0, 2]),
    joint("elbow", "revolute", side(0, [1, 0, 0]), side(7, [0, 0, 0]), [0, 0, 1]),
    joint("drive", "motor", side(-1, [0, 0, 0]), side(0, [0, 0, 0]), [0, 0, 1]),
  ]);
  const all = freedoms(arm);
  assert.deepEqual(all.map(({ name }) => name), ["shoulder", "elbow"]);
  for (const [a, b] of [[0.3, 2.9], [-3, 1], [Math.PI, -Math.PI]]) {
    const row = setFreedoms(all, [a, b], links(2));
    close(position(point(7, [1, 0, 0]), 0, row), [Math.cos(a) + Math.cos(a + b), Math.sin(a) + Math.sin(a + b), 0]);
  }
});

test("the axis is that of the first body, whichever side of the joint moves", () => {
  // both bodies are turned a quarter about x: the axis z of the first one is -y of the world
  const joined = (first: number, second: number): Scene =>
    scene([
      joint("weld", "fixed", side(-1, [0, 0, 0]), side(0, [0, 0, 0]), [0, 0, 1]),
      joint("hinge", "revolute", side(first, [first ? 0 : 1, 0, 0]), side(second, [second ? 0 : 1, 0, 0]), [0, 0, 1]),
    ]);
  for (const [first, second, sign] of [[0, 7, 1], [7, 0, -1]]) {
    const all = freedoms(joined(first, second));
    const row = setFreedoms(all, [0.4], links(2, Math.PI / 2));
    close(position(point(7, [1, 0, 0]), 0, row), [1 + Math.cos(0.4), 0, sign * Math.sin(0.4)]);
  }
});

test("a joint that shifts moves all that hangs on it along its axis", () => {
  const rail = scene([
    joint("rail", "prismatic", side(-1, [0, 0, 0]), side(0, [0, 0, 0]), [0, 3, 4]),
    joint("weld", "fixed", side(0, [1, 0, 0]), side(7, [0, 0, 0]), [0, 0, 1]),
  ]);
  const row = setFreedoms(freedoms(rail), [0.5], links(2));
  close(position(point(7, [0, 0, 0]), 0, row), [1, 0.3, 0.4]);
});

test("joints of a loop cannot be set one by one; what hangs on the loop can", () => {
  const loop = scene([
    joint("a", "revolute", side(-1, [0, 0, 0]), side(0, [0, 0, 0]), [0, 0, 1]),
    joint("b", "revolute", side(0, [1, 0, 0]), side(7, [0, 0, 0]), [0, 0, 1]),
    joint("c", "spherical", side(7, [1, 0, 0]), side(-1, [2, 0, 0]), [0, 0, 1]),
    joint("tool", "revolute", side(7, [0, 0, 0]), side(14, [0, 0, 0]), [0, 0, 1]),
  ]);
  assert.deepEqual(freedoms(loop).map(({ name, places }) => [name, [...places]]), [["tool", [14]]]);
});

test("a cylinder turns and shifts, and a long chain is searched at once", () => {
  const both = freedoms(scene([joint("rod", "cylindrical", side(-1, [0, 0, 0]), side(0, [0, 0, 0]), [1, 0, 0])]));
  assert.deepEqual(both.map(({ name, turns }) => [name, turns]), [["rod, turn", true], ["rod, shift", false]]);
  const count = 3000;
  const chain = freedoms(
    scene(Array.from({ length: count }, (_, k) => joint(`${k}`, "revolute", side(k ? 7 * k - 7 : -1, [0, 0, 0]), side(7 * k, [0, 0, 0]), [0, 0, 1]))),
  );
  assert.equal(chain.length, count);
});
