import assert from "node:assert/strict";
import { test } from "node:test";
import * as THREE from "three";
import { Rig } from "../src/render/camera";

test("points fill 88 % of the picture in one direction, centred in both, and none is outside", () => {
  for (const [width, height] of [[1200, 700], [400, 900]]) {
    for (const usesPerspective of [true, false]) {
      const rig = new Rig([0, 0, 1]);
      Object.assign(rig, { width, height, usesPerspective });
      // an arm that reaches towards the camera
      const points = [[0, 0, 0], [0.2, -3, 0.1], [0, 0, 1], [0.5, 0, 0.4]].map((x) => new THREE.Vector3(...x));
      rig.fit(points);
      rig.update(new THREE.Vector3(), 10);
      const seen = points.map((x) => x.clone().applyMatrix4(rig.camera.matrixWorldInverse).applyMatrix4(rig.camera.projectionMatrix));
      const ends = (["x", "y"] as const).map((of) => [Math.min(...seen.map((x) => x[of])), Math.max(...seen.map((x) => x[of]))]);
      // the middle is found in passes, each of which leaves a part of the error; a pixel is 2/1200
      for (const [low, high] of ends) assert.ok(Math.abs(low + high) < 2e-3, `${low} ${high}`);
      const most = Math.max(...ends.flat().map(Math.abs));
      assert.ok(Math.abs(most - 0.88) < 2e-3, `${most}`);
    }
  }
});
