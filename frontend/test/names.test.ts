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

test("a point of a reduced beam is named by element and section, one of a solid by its node", () => {
  const sections = {
    element: { data: [0, 1] }, share: { data: [0, 1] }, vertex_ring: { data: [0, 1] },
    yz: { data: new Float32Array([0, 0, 0.025, -0.05]) },
  };
  const bodies = [
    { name: "boom", nodes: { data: [1, 3] }, rings: null, sections },
    { name: "lug", nodes: { data: [7] }, rings: null, sections: null },
  ];
  const app = { runs: [{ scene: { bodies } }] } as unknown as App;
  assert.equal(placeName(app, { run: 0, body: 0, vertex: 1 }), "boom, element 2 at 100 %, y 25.0 mm, z −50.0 mm");
  assert.equal(placeName(app, { run: 0, body: 1, vertex: 0 }), "lug, node 7");
});
