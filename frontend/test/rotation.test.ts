import assert from "node:assert/strict";
import { test } from "node:test";
import { between, exponential, logarithm, matrix, product, transposedProduct, turn } from "../src/math/rotation";

const close = (a: ArrayLike<number>, b: ArrayLike<number>, tolerance = 1e-14): void => {
  assert.equal(a.length, b.length);
  for (let i = 0; i < a.length; i++) assert.ok(Math.abs(a[i] - b[i]) <= tolerance, `${i}: ${a[i]} is not ${b[i]}`);
};

test("a quarter turn about z leads x to y, whatever the length of the parameters", () => {
  const A = matrix([3, 0, 0, 3]);
  const out = [0, 0, 0];
  turn(A, 1, 0, 0, out);
  close(out, [0, 1, 0]);
  turn(A, 0, 0, 2, out);
  close(out, [0, 0, 2]);
});

test("the general matrix is that of Euler's formula", () => {
  // 2 rad about (1, 2, 2) / 3: x cos + n n.x (1 - cos) + n x x sin, for x = (1, 0, 0)
  const n = [1 / 3, 2 / 3, 2 / 3], angle = 2, c = Math.cos(angle), s = Math.sin(angle);
  const A = matrix([Math.cos(1), ...n.map((x) => Math.sin(1) * x)]);
  const column = [c + n[0] * n[0] * (1 - c), n[1] * n[0] * (1 - c) + n[2] * s, n[2] * n[0] * (1 - c) - n[1] * s];
  close([A[0], A[3], A[6]], column);
  close(exponential(n.map((x) => angle * x)), A);
});

test("the logarithm gives the rotation vector back, up to half a turn", () => {
  for (const angle of [0, 1e-9, 0.3, 2, 3.1, 3.14159, Math.PI]) {
    const n = [2 / 7, -3 / 7, 6 / 7];
    const vector = n.map((x) => angle * x);
    const found = logarithm(exponential(vector));
    // both directions are right at half a turn
    const sign = angle === Math.PI && found[2] < 0 ? -1 : 1;
    close([...found].map((x) => sign * x), vector, 1e-7);
  }
});

test("products", () => {
  const A = exponential([0.2, -0.5, 0.9]), B = exponential([1.1, 0.3, -0.2]);
  close(transposedProduct(A, product(A, B)), B);
  const x = [0, 0, 0], y = [0, 0, 0];
  turn(B, 0.3, -0.7, 2, x);
  turn(A, x[0], x[1], x[2], x);
  turn(product(A, B), 0.3, -0.7, 2, y);
  close(x, y);
});

test("half-way between two rotations, the shorter way", () => {
  const a = [1, 0, 0, 0], b = [-Math.cos(0.4), 0, -Math.sin(0.4), 0];
  close(between(a, b, 0.5), [Math.cos(0.2), 0, Math.sin(0.2), 0]);
});
