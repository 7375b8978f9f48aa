/** Extreme places of the run: a list, and numbers on the picture; a click shows place and instant. */

import { measure } from "../format/measures";
import { clock, quantity } from "../format/units";
import type { Worst } from "../protocol";
import { button, h, hint, section, toggle } from "./dom";
import type { Kit } from "./kit";
import { placeName, tried } from "./kit";

const COUNT = 6;
type Place = Worst & { run: number };
const SMALL = 3e6; // number of values of a run up to which extreme places are searched automatically

export function mountWorst(kit: Kit): void {
  const { app } = kit;
  const { store, source, slots, view, runs } = app;
  const { scene } = runs[0];
  const searched = ["von-mises", "signed-von-mises", "principal-max", "principal-min", "damage", "displacement"];
  const known = scene.measures.filter((name) => searched.includes(name));
  if (!known.length || scene.what === "live" || scene.what === "modes" || scene.frames.data.length < 2) return;

  const heading = hint("");
  const list = h("ol", "worst");
  const find = button("Find the worst places", () => void search(), { text: true, class: "wide main" });
  const marks = toggle("Numbers on the picture", (on) => (labels.hidden = !on));
  marks.set(true);
  marks.element.hidden = true;
  const labels = h("div", "labels");
  slots.overlay.append(labels);
  const panel = section("Worst places", true, heading, find, list, marks.element);
  slots.right.append(panel);

  let found: Place[] = [];
  let asked = "";
  const wanted = (): string => {
    const { measure: name } = store.state;
    return name && known.includes(name) ? name : known[0];
  };
  const go = (worst: Place): void => {
    store.set({ playing: false, measure: asked });
    if (worst.time !== null) void tried(kit, app.player.seek(worst.time));
    store.set({ selection: { run: worst.run, body: worst.body, vertex: worst.vertex } });
    void app.player.ready().then(() => view.focus(view.position(worst.run, worst.body, worst.vertex)));
  };
  const search = async (): Promise<void> => {
    const name = wanted();
    asked = name;
    heading.textContent = "Searching the run …";
    find.hidden = true;
    list.replaceChildren();
    labels.replaceChildren();
    found = [];
    const answers = await Promise.all(runs.map((_, run) => tried(kit, source.worst(run, name, COUNT))));
    if (asked !== name) return;
    const answer = answers.some((some) => some);
    found = answers
      .flatMap((some, run) => (some ?? []).map((worst) => ({ ...worst, run })))
      .sort((a, b) => Math.abs(b.value) - Math.abs(a.value))
      .slice(0, COUNT);
    if (!answer) asked = "";
    find.hidden = !!answer;
    marks.element.hidden = !found.length;
    heading.textContent = found.length
      ? `${measure(name).label}, highest over ${runs.length > 1 ? "all runs" : "the whole run"}. Click to see place and instant.`
      : "No place with a known value was found.";
    list.append(
      ...found.map((worst) => {
        const at = worst.time === null ? "" : `at ${clock(worst.time, 0.001)} s`;
        const when = runs.length > 1 ? `${at} in ${runs[worst.run].title}` : at;
        return h(
          "li",
          {},
          h(
            "button",
            { attrs: { type: "button" }, on: { click: () => go(worst) } },
            h("strong", { text: quantity(worst.value, measure(name).unit) }),
            h("span", { text: placeName(app, worst) }),
            h("small", { text: when }),
          ),
        );
      }),
    );
    labels.append(
      ...found.map((worst, k) =>
        h("button", {
          class: "worst-label takes",
          text: `${k + 1}`,
          title: `${quantity(worst.value, measure(name).unit)}, ${placeName(app, worst)}`,
          attrs: { type: "button", "aria-label": `Worst place ${k + 1}` },
          on: { click: () => go(worst) },
        }),
      ),
    );
    view.redraw();
  };
  view.onDraw(() => {
    if (!found.length || labels.hidden) return;
    const { looks, isolated, measure: name } = store.state;
    found.forEach((worst, k) => {
      const label = labels.children[k] as HTMLElement;
      const body = `${worst.run}:${worst.body}`;
      const off = name !== asked || looks[body]?.hidden || (isolated !== null && isolated !== body);
      const at = off ? null : view.project(worst.run, worst.body, worst.vertex);
      label.hidden = !at;
      if (at) label.style.transform = `translate(${at[0].toFixed(1)}px, ${at[1].toFixed(1)}px)`;
    });
  });
  const small = scene.frames.data.length * scene.row < SMALL;
  store.watch(["measure"], () => {
    if (wanted() === asked) return;
    // a page without server contains the extreme places of von Mises stress
    if (small && (source.exact || wanted() === "von-mises")) void search();
    else {
      asked = "";
      found = [];
      labels.replaceChildren();
      list.replaceChildren();
      marks.element.hidden = true;
      find.hidden = false;
      heading.textContent = "The whole run is searched; of a long run this takes a while.";
    }
  });
}
