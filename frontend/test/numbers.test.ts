import assert from "node:assert/strict";
import { test } from "node:test";
import type { Block, Body, Kind, Numbers, Scene } from "../src/protocol";
import { extent, history, probe, sensor, thinned, worst } from "../src/source/numbers";

const block = <T extends Numbers>(type: Kind, shape: number[], data: T): Block<T> => ({ type, shape, data });

/** A bar of two points, 4 m apart along x, with one mode: point 1 moves 2 m along y, stress 3 MPa. */
function bar(): Scene {
  const body: Partial<Body> = {
    name: "bar",
    kind: "solid",
    place: 0,
    modes: 1,
    positions: block("f4", [2, 3], Float32Array.of(0, 0, 0, 4, 0, 0)),
    shapes: block("f4", [1, 2, 3], Float32Array.of(0, 0, 0, 0, 2, 0)),
    stress: block("f4", [1, 2, 6], Float32Array.of(1e6, 0, 0, 0, 0, 0, 3e6, 0, 0, 4e6, 0, 0)),
    static: null,
    known: null,
    nodes: block("u4", [2], Uint32Array.of(7, 9)),
    damage: block("f4", [2], Float32Array.of(0, 0.5)),
    life: block("f4", [2], Float32Array.of(Infinity, 20)),
    rings: null,
  };
  const sensors = [{ name: "tip", unit: "N", units: ["N", "N m"], components: ["x", "m"], description: "", side: null, arrow: null, columns: null }];
  return { row: 8, window: [0, 10], bodies: [body], sensors } as unknown as Scene;
}

// R = (1, 0, 0), a quarter turn about z (x becomes y, y becomes -x), modal coordinate p
const r = Math.SQRT1_2;
const rows = Float64Array.from([0, 0.5, -1].flatMap((p) => [1, 0, 0, r, 0, 0, r, p]));
const time = [0, 1, 2];

test("a probe gives place, displacement, stress and damage", () => {
  const found = probe(bar(), rows.subarray(8, 16), 0, 1);
  assert.equal(found.node, 9);
  // (4, 2 * 0.5, 0) turned: (-1, 4, 0), then moved by (1, 0, 0)
  [0, 4, 0].forEach((x, i) => assert.ok(Math.abs(found.position[i] - x) < 1e-12));
  assert.deepEqual(found.displacement, [0, 1, 0]);
  assert.deepEqual(found.stress, [1.5e6, 0, 0, 2e6, 0, 0]);
  // sqrt(1.5^2 + 3 * 2^2) MPa
  assert.ok(Math.abs(found["von-mises"]! / (Math.sqrt(14.25) * 1e6) - 1) < 1e-12);
  assert.equal(found.damage, 0.5);
  assert.equal(found.life, 20);
});

test("a history follows the modal coordinate", () => {
  const found = history(bar(), time, rows, 0, 1, ["s12", "uy", "x", "displacement"], 100);
  assert.deepEqual([...found.time.data], time);
  assert.deepEqual(found.values.shape, [4, 3]);
  assert.deepEqual(found.units, ["Pa", "m", "m", "m"]);
  const expected = [0, 2e6, -4e6, 0, 1, -2, 1, 0, 3, 0, 1, 2];
  // the quarter turn has rounding of 1e-16 relative to 4 m
  expected.forEach((value, i) => assert.ok(Math.abs(found.values.data[i] - value) < 1e-12 * Math.max(4, Math.abs(value))));
});

test("unknown stress is not a number", () => {
  const scene = bar();
  scene.bodies[0].known = block("u1", [2], Uint8Array.of(1, 0));
  assert.equal(probe(scene, rows.subarray(8, 16), 0, 1).stress, null);
  assert.ok(Number.isNaN(history(scene, time, rows, 0, 1, ["s11"], 10).values.data[1]));
});

test("extent and worst place of a run", () => {
  assert.deepEqual(extent(bar(), time, rows, "s11"), [-3e6, 1.5e6]);
  const [first, second] = worst(bar(), time, rows, "s11", 5);
  assert.equal(first.vertex, 1);
  assert.equal(first.time, 2);
  assert.equal(first.value, -3e6);
  assert.match(first.label, /node 9/);
  assert.equal(second.vertex, 0);
  assert.equal(second.value, -1e6);
});

test("thinned curves keep lowest and highest values", () => {
  const n = 10000;
  const times = Float64Array.from({ length: n }, (_, i) => i);
  const curve = Float64Array.from(times, (t) => Math.sin(t / 50));
  curve[4321] = 7;
  curve[8765] = -9;
  const found = thinned(times, [curve], 200);
  assert.ok(found.time.data.length <= 200);
  assert.equal(Math.max(...found.values.data), 7);
  assert.equal(Math.min(...found.values.data), -9);
  assert.equal(found.time.data[0], 0);
  assert.equal(found.time.data[found.time.data.length - 1], n - 1);
  assert.ok(found.time.data.every((t, i) => i === 0 || t > found.time.data[i - 1]));
});

test("sensors give a curve for each component, a missing one is named", () => {
  const values = { tip: block("f4", [2, 3], Float32Array.of(1, 2, 3, 4, 5, 6)) };
  const stored = { time: block("f8", [3], Float64Array.from(time)), values };
  const found = sensor(bar(), stored, ["tip"], 100);
  assert.deepEqual(found.labels, ["tip x", "tip m"]);
  assert.deepEqual(found.units, ["N", "N m"]);
  assert.deepEqual([...found.values.data], [1, 2, 3, 4, 5, 6]);
  assert.throws(() => sensor(bar(), stored, ["other"], 100), /other/);
});
