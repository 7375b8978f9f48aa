/** Parts of a hydraulic cylinder: the piston moves with the distance of its ends. */

import assert from "node:assert/strict";
import { test } from "node:test";
import { cylinderParts } from "../src/render/symbols/kinds";

test("the piston of a cylinder is where its stroke says", () => {
  const sizes = { closed: 0.6, stroke: 0.4 };
  for (const x of [0, 0.1, 0.4]) {
    const { barrel, piston } = cylinderParts(0.6 + x, sizes);
    assert.equal(barrel, 0.6);
    // the barrel is 0.2 m longer than the stroke, half of it at each end
    assert.ok(Math.abs(piston - (0.1 + x)) < 1e-15);
  }
  // beyond its ends the piston stays in the barrel
  assert.equal(cylinderParts(2.0, sizes).piston, 0.6);
  assert.deepEqual(cylinderParts(0.3, sizes), { barrel: 0.3, piston: 0 });
});
