import assert from "node:assert/strict";
import { test } from "node:test";
import { measure, principal, vonMises } from "../src/math/tensor";

const near = (a: number, b: number, scale = 100): void => assert.ok(Math.abs(a - b) < 1e-12 * scale, `${a} is not ${b}`);

test("principal stresses of cases with closed forms", () => {
  // Mohr's circle: 50 +- sqrt(20^2 + 21^2) in the plane of 2 and 3
  const cases: [number[], number[]][] = [
    [[0, 0, 0, 100, 0, 0], [100, 0, -100]],
    [[10, 70, 30, 0, 21, 0], [79, 21, 10]],
    [[7, 7, 7, 0, 0, 0], [7, 7, 7]],
    [[0, 0, 0, 0, 0, 0], [0, 0, 0]],
    [[-40, 0, 0, 0, 0, 0], [0, 0, -40]],
  ];
  for (const [stress, expected] of cases) {
    // two equal values: a rounding error e of the cosine moves them by sqrt(e)
    principal(stress).forEach((value, i) => assert.ok(Math.abs(value - expected[i]) < 1e-6, `${value} is not ${expected[i]}`));
  }
});

test("equivalent stress", () => {
  near(vonMises([100, 0, 0, 0, 0, 0]), 100);
  near(vonMises([0, 0, 0, 0, 100, 0]), 100 * Math.sqrt(3));
  near(vonMises([5, 5, 5, 0, 0, 0]), 0);
  near(measure("signed-von-mises", [-50, 0, 0, 0, 0, 0]), -50);
  near(measure("signed-von-mises", [0, 50, 0, 0, 0, 0]), 50);
  // opposite principal stresses along x and y, whatever lies between them, have the same sign in all axes
  for (let i = 0; i < 100; i++) {
    const a = Math.cos(i), b = Math.sin(i), c = Math.cos(0.7 * i), d = Math.sin(0.7 * i);
    const x = [a * c, b * c, d], y = [-b, a, 0], z = [-a * d, -b * d, c];
    const stress = [[0, 0], [1, 1], [2, 2], [0, 1], [1, 2], [0, 2]].map(([j, k]) => 100 * (x[j] * x[k] - y[j] * y[k]) - i * z[j] * z[k]);
    near(measure("signed-von-mises", stress), Math.sqrt(3e4 + i * i));
  }
  near(measure("principal-max", [0, 0, 0, 100, 0, 0]), 100);
  near(measure("principal-min", [0, 0, 0, 100, 0, 0]), -100);
  near(measure("s13", [1, 2, 3, 4, 5, 6]), 6);
  assert.ok(Number.isNaN(measure("nothing", [1, 2, 3, 4, 5, 6])));
});
