import assert from "node:assert/strict";
import { test } from "node:test";
import type { App } from "../src/app";
import { thicken } from "../src/motion/thicken";
import { placeName } from "../src/panels/kit";
import type { Scene } from "../src/protocol";

test("a point of a beam is named by element and section, also where it is drawn thicker", () => {
  const rings = {
    element: { data: [2] }, share: { data: [0.5] }, vertex_ring: { data: [0, 0] },
    yz: { data: new Float32Array([0.25, -0.5, -0.25, 0.5]) }, least: 0.1,
  };
  const scene = { box: [[0, 0, 0], [100, 0, 0]], bodies: [{ name: "cable", nodes: null, rings }] } as unknown as Scene;
  thicken(scene);
  assert.equal(rings.yz.data[0], 2.5); // 10 m thick, as a tenth of 100 m
  const app = { runs: [{ scene }] } as unknown as App;
  assert.equal(placeName(app, { run: 0, body: 0, vertex: 0 }), "cable, element 3 at 50.0 %, y 250 mm, z −500 mm");
});
