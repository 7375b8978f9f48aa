/** Sliders of the joints of a static machine. */

import { number, quantity } from "../format/units";
import { freedoms } from "../motion/joints";
import { StillTrack } from "../motion/track";
import { button, hint, section, slider } from "./dom";
import type { Kit } from "./kit";

const FEW = 12; // number of sliders that are open at the same time
const DEGREE = Math.PI / 180;

export function mountJoints(kit: Kit): void {
  const { scene, track } = kit.app.runs[0];
  if (!(track instanceof StillTrack)) return;
  const all = freedoms(scene);
  if (!all.length) return;
  const [low, high] = scene.box;
  const size = Math.hypot(...low.map((x, i) => high[i] - x));
  const values = all.map(() => 0);
  const show = (): void => {
    track.pose(all, values);
    kit.app.store.set({ selection: kit.app.store.state.selection && { ...kit.app.store.state.selection } });
  };
  const sliders = all.map(({ name, turns }, k) => {
    const most = turns ? 180 : size;
    const made = slider(
      name,
      { low: -most, high: most, ...(turns ? { step: 1 } : {}) },
      (v) => (turns ? `${number(v, 3)}°` : quantity(v, "m", 3)),
      (v) => {
        values[k] = turns ? v * DEGREE : v;
        show();
      },
    );
    made.set(0);
    return made;
  });
  const back = button("Back to the pose of the model", () => {
    values.fill(0);
    for (const one of sliders) one.set(0);
    show();
  }, { text: true });
  kit.app.slots.right.append(
    section("Joints", all.length <= FEW, hint("From the pose of the model; parts do not deform, stops do not stop."), ...sliders.map(({ element }) => element), back),
  );
}
