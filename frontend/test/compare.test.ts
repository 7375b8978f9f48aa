import assert from "node:assert/strict";
import { test } from "node:test";
import { difference, unlike } from "../src/format/compare";
import type { Scene } from "../src/protocol";

test("the difference of two curves at the instants of both, where both are known", () => {
  const a = { time: [0, 1, 2, 3], values: [0, 1, 2, 3] }; // t
  const b = { time: [0.5, 1.5, 2, 5], values: [1, 3, 4, 10] }; // 2 t
  const { time, values } = difference(a, b);
  assert.deepEqual([...time], [0.5, 1, 1.5, 2, 3]);
  assert.deepEqual([...values], [0.5, 1, 1.5, 2, 3]); // t, exact in binary
});

test("what is unknown stays so, and only there", () => {
  const a = { time: [0, 1, 2], values: [0, 0, 0] };
  const { values } = difference(a, { time: [0, 1, 2], values: [4, NaN, 5] });
  assert.deepEqual([...values], [4, NaN, 5]);
});

test("curves that share no instant have no difference", () => {
  assert.equal(difference({ time: [0, 1], values: [0, 1] }, { time: [2, 3], values: [0, 1] }).time.length, 0);
  assert.equal(difference({ time: [], values: [] }, { time: [2], values: [0] }).time.length, 0);
});

test("different machines are named with what differs, equal ones are not", () => {
  const scene = (bodies: string[], joints: string[]): Scene =>
    ({ bodies: bodies.map((name) => ({ name })), symbols: joints.map((name) => ({ name, group: "joint" })) }) as unknown as Scene;
  const first = scene(["arm", "ball"], ["hinge"]);
  assert.equal(unlike(first, scene(["ball", "arm"], ["hinge"]), ["a.h5", "b.h5"]), "");
  assert.equal(
    unlike(first, scene(["arm", "rod", "bob"], ["hinge", "weld"]), ["a.h5", "b.h5"]),
    "b.h5 is another machine than a.h5: without body 'ball', with bodies 'rod', 'bob', with joint 'weld'.",
  );
});
