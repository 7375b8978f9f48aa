/** Display settings: amplification, symbols, arrows, edges, light, camera, clipping plane. */

import { number } from "../format/units";
import type { Clip, State } from "../state";
import { button, choice, h, section, select, slider, toggle } from "./dom";
import type { Kit } from "./kit";
import { key } from "../state";

type Switch = { [K in keyof State]: State[K] extends boolean ? K : never }[keyof State];

export function mountDisplay(kit: Kit): void {
  const { app } = kit;
  const { store } = app;
  const scene = app.runs[0].scene;
  const flexible = scene.bodies.some((body) => body.modes > 0);
  const parts: HTMLElement[] = [];
  if (flexible) parts.push(amplification(kit));

  const flag = (label: string, name: Switch): HTMLElement => {
    const made = toggle(label, (on) => store.set({ [name]: on }));
    store.watch([name], (state) => made.set(state[name]));
    return made.element;
  };
  for (const [group, label] of [
    ["joint", "Joints"],
    ["force", "Forces and springs"],
    ["sensor", "Sensors"],
    ["ground", "Ground"],
  ] as const) {
    if (!scene.symbols.some((symbol) => symbol.group === group)) continue;
    const made = toggle(label, (on) => store.set({ symbols: { ...store.state.symbols, [group]: on } }));
    store.watch(["symbols"], ({ symbols }) => made.set(symbols[group]));
    parts.push(made.element);
  }
  if (scene.bodies.some(({ kind }) => kind === "contact")) parts.push(flag("Contact shapes", "contacts"));
  if (scene.markers.length) parts.push(flag("Markers", "markers"));
  const arrows = scene.sensors.some((sensor) => sensor.arrow) || scene.symbols.some(({ group }) => group === "force");
  if (arrows) parts.push(flag("Force and velocity arrows", "arrows"));
  if (scene.touches !== null) parts.push(flag("Contact forces", "touches"));
  if (arrows || scene.touches !== null) {
    const scale = slider("Length of arrows", { low: 0.1, high: 10, log: true }, (v) => `× ${number(v, 2)}`, (v) =>
      store.set({ arrowScale: v }),
    );
    store.watch(["arrowScale"], (state) => scale.set(state.arrowScale));
    store.watch(["arrows", "touches"], (state) => {
      scale.element.hidden = !(arrows && state.arrows) && !(scene.touches !== null && state.touches);
    });
    parts.push(scale.element);
  }
  parts.push(flag("Edges", "edges"), flag("Element mesh", "mesh"), flag("Grid", "grid"), flag("Shadows", "shadows"));
  app.slots.right.append(section("Show", window.innerWidth > 900, ...parts), camera(kit), clipping(kit));
}

function amplification(kit: Kit): HTMLElement {
  const { store } = kit.app;
  const text = (v: number): string => (v < 1.02 ? "true size" : `× ${number(v, v < 10 ? 2 : 3)}`);
  const set = (v: number): void => store.set({ amplification: v < 1.02 ? 1 : v });
  const made = slider("Deformation", { low: 1, high: 1000, log: true }, text, set);
  store.watch(["amplification"], (state) => made.set(Math.max(1, state.amplification)));
  const quick = h("div", "quick");
  for (const value of [1, 10, 100]) {
    quick.append(button(value === 1 ? "true size" : `× ${value}`, () => set(value), { text: true }));
  }
  return h("div", "rows", made.element, quick);
}

function camera(kit: Kit): HTMLElement {
  const { app } = kit;
  const { store, view } = app;
  const axes = h("div", "axes");
  for (const [side, label] of [["iso", "Oblique"], ["x", "+x"], ["-x", "−x"], ["y", "+y"], ["-y", "−y"], ["z", "+z"], ["-z", "−z"]] as const) {
    axes.append(button(side === "iso" ? label : `From ${label}`, () => view.look(side), { text: true }));
    axes.lastElementChild!.querySelector("span")!.textContent = label;
  }
  const kind = choice<"p" | "o">("Projection", [["p", "Perspective"], ["o", "Parallel"]], (value) =>
    store.set({ perspective: value === "p" }),
  );
  store.watch(["perspective"], (state) => kind.set(state.perspective ? "p" : "o"));
  const bodies = app.runs[0].scene.bodies;
  const follow = select(
    "Follow",
    [["", "Nothing"], ...bodies.flatMap((body, i) => (body.place >= 0 ? [[key(0, i), body.name] as const] : []))],
    (value) => store.set({ follow: value || null }),
  );
  store.watch(["follow"], (state) => follow.set(state.follow ?? ""));
  return section("Camera", false, axes, kind.element, follow.element);
}

const NORMALS: Record<string, Clip["normal"]> = { x: [1, 0, 0], y: [0, 1, 0], z: [0, 0, 1] };

function clipping(kit: Kit): HTMLElement {
  const { store } = kit.app;
  const change = (clip: Partial<Clip>): void => store.set({ clip: { ...store.state.clip, ...clip } });
  const on = toggle("Cut by a plane", (value) => change({ on: value }));
  const axis = choice<"x" | "y" | "z">("Normal of the plane", [["x", "x"], ["y", "y"], ["z", "z"]], (name) => {
    const flipped = store.state.clip.normal.some((value) => value < 0);
    change({ normal: NORMALS[name].map((value) => (flipped ? -value : value)) as Clip["normal"] });
  });
  const place = slider("Position", { low: -1, high: 1, step: 0.005 }, (v) => `${number(Math.round(50 * (v + 1)), 3)} %`, (v) => {
    const flipped = store.state.clip.normal.some((value) => value < 0);
    change({ offset: flipped ? -v : v });
  });
  const flip = button(
    "Other side",
    () => {
      const { normal, offset } = store.state.clip;
      change({ normal: normal.map((v) => -v + 0) as Clip["normal"], offset: -offset });
    },
    { text: true, class: "wide" },
  );
  const more = h("div", "rows", h("div", "field", h("span", { text: "Normal" }), axis.element), place.element, flip);
  store.watch(["clip"], ({ clip }) => {
    on.set(clip.on);
    more.hidden = !clip.on;
    const k = clip.normal.findIndex((value) => value !== 0);
    axis.set((["x", "y", "z"] as const)[k]);
    place.set(clip.normal[k] < 0 ? -clip.offset : clip.offset);
  });
  return section("Section plane", false, on.element, more);
}
