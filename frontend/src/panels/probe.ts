/** Values under the cursor, in double precision, requested when the cursor rests. */

import { measure } from "../format/measures";
import { fixed, quantity } from "../format/units";
import type { Hit } from "../render/view";
import type { Touch } from "../render/symbols/touches";
import type { Place } from "../state";
import { debounced, h } from "./dom";
import type { Kit } from "./kit";
import { placeName, probed } from "./kit";

/** Numbers of a contact. */
function lines(touch: Touch): HTMLElement[] {
  const rows: [string, string][] = [
    ["normal force", quantity(touch.normal, "N")],
    ["friction", quantity(touch.friction, "N")],
    ["gap", quantity(touch.gap, "m")],
  ];
  if (Number.isFinite(touch.pressure) && touch.pressure > 0) rows.push(["pressure", quantity(touch.pressure, "Pa")]);
  if (touch.approach > 0) rows.push(["approach", quantity(touch.approach, "m/s")]);
  if (Number.isFinite(touch.age)) rows.push(["touches since", quantity(touch.age, "s")]);
  rows.push(["x, y, z", `${touch.at.toArray().map((x) => fixed(x, 4)).join(", ")} m`]);
  return rows.flatMap(([term, text]) => [h("dt", { text: term }), h("dd", { text })]);
}

export function mountProbe(kit: Kit): void {
  const { app } = kit;
  const { store, view, source, slots } = app;
  const name = h("div", "name");
  const figures = h("dl");
  const element = h("div", { class: "probe" }, name, figures);
  element.hidden = true;
  slots.overlay.append(element);

  let asked = 0;
  const ask = debounced(80, async (place: Place, time: number) => {
    const number = ++asked;
    try {
      const found = await probed(app, place, time);
      if (number !== asked || store.state.hover?.vertex !== place.vertex) return;
      const shift = Math.hypot(...found.displacement);
      const lines: [string, string][] = [];
      if (found["von-mises"] !== null) lines.push(["von Mises", quantity(found["von-mises"], "Pa")]);
      const chosen = store.state.measure;
      if (chosen && chosen !== "von-mises" && chosen !== "displacement" && !source.live) {
        const value = view.value(place.run, place.body, place.vertex);
        if (!Number.isNaN(value)) lines.push([measure(chosen).label, quantity(value, measure(chosen).unit)]);
      }
      if (Number.isFinite(shift) && shift > 0) lines.push(["displacement", quantity(shift, "m")]);
      if (found.damage !== null) lines.push(["damage", quantity(found.damage, "1", 3)]);
      if (found.life !== null) lines.push(["life", quantity(found.life, "s", 3)]);
      lines.push(["x, y, z", `${found.position.map((x) => fixed(x, 4)).join(", ")} m`]);
      figures.replaceChildren(...lines.flatMap(([term, text]) => [h("dt", { text: term }), h("dd", { text })]));
    } catch {
      // the place may no longer exist: other window, end of the server
      if (number === asked) figures.replaceChildren();
    }
  });
  const place = (): void => {
    const { hover } = store.state;
    const at = hover && view.project(hover.run, hover.body, hover.vertex);
    element.hidden = !at;
    if (!at) return;
    const { clientWidth, clientHeight } = slots.stage;
    const [width, height] = [element.offsetWidth, element.offsetHeight];
    const x = at[0] + 16 + width > clientWidth ? at[0] - 16 - width : at[0] + 16;
    const y = Math.min(Math.max(8, at[1] + 14), clientHeight - height - 8);
    element.style.transform = `translate(${Math.max(8, x).toFixed(0)}px, ${y.toFixed(0)}px)`;
  };
  let last: Place | null = null;
  store.watch(["hover", "time"], ({ hover, time, playing }) => {
    if (hover && (hover !== last || !playing)) {
      if (hover !== last) {
        name.textContent = placeName(app, hover);
        figures.replaceChildren();
      }
      ask(hover, time);
    }
    last = hover;
    place();
  });
  view.onDraw(place);

  // symbols have their own text
  const tip = h("div", { class: "probe tip" });
  tip.hidden = true;
  slots.overlay.append(tip);
  const show = (x: number, y: number, hit: Hit | null): void => {
    const known = hit?.symbol === undefined ? undefined : app.runs[hit.run].scene.symbols[hit.symbol];
    const touch = hit?.touch === undefined ? undefined : view.machines[hit.run].touches?.shown[hit.touch];
    tip.hidden = !known && !touch;
    if (known) tip.textContent = known.text || `${known.name} (${known.kind})`;
    if (touch) tip.replaceChildren(h("div", { class: "name", text: touch.text }), h("dl", {}, ...lines(touch)));
    tip.style.transform = `translate(${x + 14}px, ${y + 12}px)`;
  };
  const symbolAt = debounced(60, (x: number, y: number) => {
    if (!store.state.playing && !store.state.hover) show(x, y, view.pick(x, y));
  });
  view.onClick(({ x, y, hit }) => show(x, y, hit));
  view.canvas.addEventListener("pointermove", (event) => {
    tip.hidden = true;
    if (event.pointerType === "touch" || event.buttons) return;
    const box = view.canvas.getBoundingClientRect();
    symbolAt(event.clientX - box.left, event.clientY - box.top);
  });
  view.canvas.addEventListener("pointerleave", () => (tip.hidden = true));
}
