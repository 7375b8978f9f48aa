/** Keys of the page, and the overlay that lists them. */

import { button, h } from "./dom";
import type { Kit } from "./kit";
import { toggleTrace } from "./selection";
import { nextTheme } from "./theme";

interface Key {
  /** Values of `KeyboardEvent.key` for one command. */
  keys: string[];
  shown: string;
  label: string;
  call: () => void;
}

const MOUSE: [string, string][] = [
  ["drag", "turn"],
  ["right or middle drag, shift + drag", "move"],
  ["wheel, two fingers", "zoom to the cursor"],
  ["click", "numbers and curves of a point"],
  ["double click", "turn about a point"],
  ["wheel on the time line", "step by frame; with ctrl: zoom into time"],
];

function table(kit: Kit): Key[] {
  const { store, player, view, runs } = kit.app;
  const measures = [null, ...runs[0].scene.measures];
  const amplify = (factor: number): void =>
    store.set({ amplification: Math.min(1000, Math.max(1, store.state.amplification * factor)) });
  const modes = runs[0].scene.modes?.length ?? 0;
  const mode = (way: number): void => store.set({ mode: (store.state.mode + way + modes) % modes });
  const time: Key[] = [
    { keys: [" "], shown: "space", label: "play, pause", call: () => player.toggle() },
    { keys: ["ArrowLeft"], shown: "←", label: "one frame back", call: () => player.step(-1) },
    { keys: ["ArrowRight"], shown: "→", label: "one frame on", call: () => player.step(1) },
    { keys: ["Home"], shown: "Home", label: "start", call: () => void player.seek(player.start) },
    { keys: ["End"], shown: "End", label: "end", call: () => void player.seek(player.end) },
    { keys: [","], shown: ",", label: "half the speed", call: () => store.set({ speed: store.state.speed / 2 }) },
    { keys: ["."], shown: ".", label: "twice the speed", call: () => store.set({ speed: store.state.speed * 2 }) },
    { keys: ["l"], shown: "L", label: "repeat", call: () => store.set({ loop: !store.state.loop }) },
  ];
  const steer: Key[] = modes
    ? [
        { keys: ["ArrowUp"], shown: "↑", label: "mode before", call: () => mode(-1) },
        { keys: ["ArrowDown"], shown: "↓", label: "next mode", call: () => mode(1) },
      ]
    : [];
  const moves = player.end > player.start && !kit.app.source.live;
  return [
    ...(moves ? time : []),
    ...steer,
    { keys: ["f"], shown: "F", label: "fit all into the picture", call: () => view.fit() },
    { keys: ["0"], shown: "0", label: "oblique view", call: () => view.look("iso") },
    ...(["x", "y", "z"] as const).flatMap((axis, i): Key[] => [
      { keys: [`${i + 1}`], shown: `${i + 1}`, label: `view from +${axis}`, call: () => view.look(axis) },
      { keys: [`${i + 4}`], shown: `${i + 4}`, label: `view from −${axis}`, call: () => view.look(`-${axis}`) },
    ]),
    { keys: ["p"], shown: "P", label: "perspective or parallel", call: () => store.set({ perspective: !store.state.perspective }) },
    {
      keys: ["c"],
      shown: "C",
      label: "next meaning of the colours",
      call: () => {
        const at = measures.indexOf(store.state.measure);
        store.set({ measure: measures[(at + 1) % measures.length], range: null });
      },
    },
    { keys: ["i"], shown: "I", label: "isolines", call: () => store.set({ isolines: !store.state.isolines }) },
    { keys: ["e"], shown: "E", label: "element mesh", call: () => store.set({ mesh: !store.state.mesh }) },
    { keys: ["+", "="], shown: "+", label: "more deformation", call: () => amplify(1.25) },
    { keys: ["-"], shown: "−", label: "less deformation", call: () => amplify(0.8) },
    { keys: ["m"], shown: "M", label: "measure a distance", call: () => store.set({ tool: store.state.tool === "measure" ? "select" : "measure" }) },
    { keys: ["t"], shown: "T", label: "path of the chosen point", call: () => toggleTrace(kit) },
    { keys: ["k"], shown: "K", label: "section plane", call: () => store.set({ clip: { ...store.state.clip, on: !store.state.clip.on } }) },
    { keys: ["g"], shown: "G", label: "grid", call: () => store.set({ grid: !store.state.grid }) },
    { keys: ["d"], shown: "D", label: "light or dark", call: () => nextTheme(kit) },
    {
      keys: ["Escape"],
      shown: "Esc",
      label: "deselect, show everything, end a tool",
      call: () => store.set(store.state.tool === "select" ? { selection: null, isolated: null } : { tool: "select" }),
    },
  ];
}

/** Listen to keys; returns the function that shows the overlay. */
export function mountKeys(kit: Kit): () => void {
  const all = table(kit);
  const dialog = h("dialog", { class: "help", attrs: { "aria-label": "Keys and mouse" } });
  const show = (): void => (dialog.open ? dialog.close() : dialog.showModal());
  const entry = (shown: string, label: string): HTMLElement =>
    h("div", "entry", h("kbd", { text: shown }), h("span", { text: label }));
  dialog.append(
    h("header", {}, h("h2", { text: "Keys and mouse" }), button("Close", () => dialog.close(), { icon: "close" })),
    h("div", "columns", ...MOUSE.map(([how, what]) => entry(how, what)), ...all.map((key) => entry(key.shown, key.label)), entry("?", "this list")),
  );
  dialog.addEventListener("click", (event) => event.target === dialog && dialog.close());
  document.body.append(dialog);
  window.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || event.defaultPrevented) return;
    const { target } = event;
    const typing =
      target instanceof HTMLSelectElement ||
      (target instanceof HTMLInputElement && !["checkbox", "range", "color"].includes(target.type));
    if (typing && event.key !== "Escape") return;
    // space on a button and arrows on a slider keep their meaning
    if (event.key === " " && target instanceof HTMLElement && target.closest("button, summary, input:not([type=range])")) return;
    if (event.key.startsWith("Arrow") && target instanceof HTMLInputElement) return;
    if (event.key === "?") {
      event.preventDefault();
      show();
      return;
    }
    if (dialog.open) return;
    const found = all.find(({ keys }) => keys.includes(event.key.length === 1 ? event.key.toLowerCase() : event.key));
    if (!found) return;
    event.preventDefault();
    found.call();
  });
  return show;
}
