/** Modes of a part or of a machine: a list with frequency and damping; the chosen one is played. */

import { number, quantity } from "../format/units";
import type { Mode } from "../protocol";
import { h, hint, section } from "./dom";
import type { Kit } from "./kit";

export function mountModes(kit: Kit): void {
  const { app } = kit;
  const { store, runs } = app;
  const modes = runs[0].scene.modes ?? [];
  if (!modes.length) return;
  const note = hint("");
  const list = h("div", { class: "modes", attrs: { role: "listbox", "aria-label": "Modes", tabindex: "0" } });
  const rows = modes.map((mode, k) => {
    const row = h(
      "div",
      { class: "mode", attrs: { role: "option", id: `mode-${k}` }, on: { click: () => choose(k) } },
      h("span", { text: mode.label }),
      h("strong", { text: frequency(mode) }),
      h("small", { text: damping(mode) }),
    );
    list.append(row);
    return row;
  });
  const choose = (k: number): void =>
    store.set({ mode: Math.max(0, Math.min(modes.length - 1, k)), time: app.player.start });
  list.addEventListener("keydown", (event) => {
    const way = { ArrowUp: -1, ArrowDown: 1, PageUp: -10, PageDown: 10 }[event.key];
    if (!way) return;
    event.preventDefault();
    event.stopPropagation();
    choose(store.state.mode + way);
  });
  app.slots.right.append(section("Modes", true, list, note));
  store.watch(["mode"], ({ mode }) => {
    rows.forEach((row, k) => row.setAttribute("aria-selected", String(k === mode)));
    list.setAttribute("aria-activedescendant", `mode-${mode}`);
    rows[mode]?.scrollIntoView({ block: "nearest" });
    note.textContent = modes[mode]?.note ?? "";
    note.hidden = !note.textContent;
  });
  if (app.player.end > app.player.start) app.player.play();
}

const frequency = ({ frequency: f }: Mode): string => (f > 0 ? quantity(f, "Hz", 5) : "0 Hz");

/** Damping ratio in percent. */
function damping({ damping: ratio }: Mode): string {
  if (ratio === null) return "";
  return ratio < 0 ? `unstable, ${number(100 * ratio, 3)} %` : `damping ${number(100 * ratio, 3)} %`;
}
