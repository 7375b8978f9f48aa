/** Minimum thickness of drawn beams, for visibility. */

import type { Scene } from "../protocol";

/** Widen thinner sections of exact beams to a share of the scene's size. */
export function thicken(scene: Scene): void {
  const [low, high] = scene.box;
  const extent = Math.max(...[0, 1, 2].map((i) => high[i] - low[i]));
  for (const { rings } of scene.bodies) {
    if (!rings) continue;
    rings.section ??= rings.yz.data.slice();
    const yz = rings.yz.data, count = rings.element.data.length;
    const ends = Array.from({ length: count }, () => [Infinity, -Infinity, Infinity, -Infinity]);
    rings.vertex_ring.data.forEach((ring, v) => {
      const e = ends[ring], y = yz[2 * v], z = yz[2 * v + 1];
      ends[ring] = [Math.min(e[0], y), Math.max(e[1], y), Math.min(e[2], z), Math.max(e[3], z)];
    });
    rings.vertex_ring.data.forEach((ring, v) => {
      const thick = Math.max(ends[ring][1] - ends[ring][0], ends[ring][3] - ends[ring][2]);
      const factor = thick > 0 ? Math.max(1, (rings.least * extent) / thick) : 1;
      yz[2 * v] *= factor;
      yz[2 * v + 1] *= factor;
    });
  }
}
