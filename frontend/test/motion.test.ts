import assert from "node:assert/strict";
import { test } from "node:test";
import { before, blend } from "../src/motion/track";
import { roundStep } from "../src/render/grid";
import { smooth } from "../src/render/smooth";
import { Store } from "../src/state";

test("the frame before a time", () => {
  const times = [0, 0.1, 0.4, 1];
  assert.deepEqual([-1, 0, 0.05, 0.1, 0.39, 0.4, 2].map((t) => before(times, t)), [0, 0, 0, 1, 1, 2, 3]);
});

test("between frames Euler parameters take the shorter way", () => {
  const a = [5, 1, 0, 0, 0], b = [7, -1, 0, 0, 0];
  assert.deepEqual([...blend(a, b, 0.5, [1], new Float64Array(5))], [6, 1, 0, 0, 0]);
});

test("normals are smooth over flat edges and break at creases", () => {
  // two triangles in the plane z = 0 that share an edge, and one upright at another edge
  const x = new Float32Array([0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0, 0, 1]);
  const made = smooth(x, new Uint32Array([0, 1, 2, 0, 2, 3, 0, 3, 4]));
  assert.equal(made.index.length, 9);
  assert.deepEqual([...made.index].map((i) => made.source[i]), [0, 1, 2, 0, 2, 3, 0, 3, 4]);
  // vertices 0 and 3 have two normals, the others one
  assert.equal(made.source.length, 7);
  const normal = (corner: number): number[] => [...made.normals.slice(3 * made.index[corner], 3 * made.index[corner] + 3)];
  assert.deepEqual(normal(0), [0, 0, 1]);
  assert.deepEqual(normal(3), [0, 0, 1]);
  assert.deepEqual(normal(6), [1, 0, 0]);
});

test("steps of the grid are 1, 2 or 5 times a power of ten", () => {
  assert.deepEqual([0.3, 1, 2, 4.9, 70, 0.06].map(roundStep), [0.2, 1, 2, 2, 50, 0.05]);
});

test("watchers hear of what they watch, and only if it has changed", () => {
  const store = new Store();
  const heard: number[] = [];
  let any = 0;
  store.watch(null, () => any++);
  const stop = store.watch(["time"], ({ time }) => heard.push(time));
  store.set({ time: 0 });
  store.set({ speed: 2 });
  store.set({ time: 3, speed: 1 });
  stop();
  store.set({ time: 4 });
  assert.deepEqual(heard, [0, 3]);
  assert.equal(any, 4);
});
