/** Menus of the picture and of the video. */

import { encodes, instants, video } from "../export/video";
import { picture } from "../export/picture";
import { number } from "../format/units";
import { FramesTrack, ModeTrack } from "../motion/track";
import { button, choice, download, fileName, h, hint, select, toggle } from "./dom";
import type { Kit } from "./kit";
import { tried } from "./kit";

/** Button that opens a small panel below it. */
function menu(label: string, symbol: string, content: HTMLElement): HTMLElement {
  const panel = h("div", { class: "menu", attrs: { role: "dialog", "aria-label": label } }, content);
  panel.hidden = true;
  const opener = button(label, () => set(panel.hidden === true), { icon: symbol });
  const set = (open: boolean): void => {
    panel.hidden = !open;
    opener.setAttribute("aria-expanded", String(open));
    if (open) panel.querySelector<HTMLElement>("button, input, select")?.focus({ preventScroll: true });
  };
  set(false);
  const box = h("div", "menu-box", opener, panel);
  document.addEventListener("pointerdown", (event) => {
    if (!panel.hidden && !box.contains(event.target as Node)) set(false);
  });
  // independent of the focus, which mouse clicks do not set
  window.addEventListener(
    "keydown",
    (event) => {
      if (event.key !== "Escape" || panel.hidden) return;
      event.stopPropagation();
      if (box.contains(document.activeElement)) opener.focus();
      set(false);
    },
    { capture: true },
  );
  return box;
}

const title = (kit: Kit): string => kit.app.runs[0].scene.title || kit.app.runs[0].scene.name;

export function pictureMenu(kit: Kit): HTMLElement {
  const options = { scale: 2, legend: true, transparent: false };
  const size = choice<"1" | "2" | "4">("Size", [["1", "1 ×"], ["2", "2 ×"], ["4", "4 ×"]], (value) => {
    options.scale = Number(value);
    size.set(value);
  });
  size.set("2");
  const legend = toggle("Legend and title", (on) => (options.legend = on));
  legend.set(true);
  const clear = toggle("Transparent background", (on) => (options.transparent = on));
  const save = button("Save picture (PNG)", async () => {
    const made = await tried(kit, picture(kit.app, options));
    if (made) download(fileName(title(kit), "png"), made);
  }, { text: true, class: "wide main" });
  return menu(
    "Picture",
    "camera",
    h("div", "rows", h("div", "field", h("span", { text: "Size" }), size.element), legend.element, clear.element, save),
  );
}

export function videoMenu(kit: Kit): HTMLElement {
  const { app } = kit;
  const { store, player } = app;
  const options = { rate: 30, legend: true };
  const rate = select("Pictures a second", [["25", "25"], ["30", "30"], ["50", "50"], ["60", "60"]], (value) => {
    options.rate = Number(value);
    tell();
  });
  rate.set("30");
  const legend = toggle("Legend and title", (on) => (options.legend = on));
  legend.set(true);
  const length = hint("");
  const bar = h("progress", { attrs: { max: "1", value: "0", "aria-label": "Progress of the video" } });
  bar.hidden = true;
  let running = false;
  let cancelled = false;
  const save = button("Save video (WebM)", () => void (running ? (cancelled = true) : make()), { text: true, class: "wide main" });
  const modes = app.runs[0].track instanceof ModeTrack;
  const make = async (): Promise<void> => {
    running = true;
    cancelled = false;
    bar.hidden = false;
    save.querySelector("span")!.textContent = "Cancel";
    const { start, end } = player;
    const { speed } = store.state;
    const made = await tried(
      kit,
      video(app, {
        ...options,
        speed,
        start,
        end,
        progress: (share) => (bar.value = share),
        cancelled: () => cancelled,
      }),
    );
    running = false;
    bar.hidden = true;
    save.querySelector("span")!.textContent = "Save video (WebM)";
    if (!made) return;
    download(fileName(title(kit), "webm"), made);
    kit.say(`The video is saved (${(made.size / 1e6).toFixed(1)} MB).`);
  };
  const tell = (): void => {
    const { speed } = store.state;
    const { start, end } = player;
    const count = instants(start, end, speed, options.rate).length;
    length.textContent =
      `${modes ? "One period" : "The frames of the time line"} at the speed chosen there: ` +
      `${number((end - start) / speed, 3)} s, ${count} pictures.` +
      (encodes() ? "" : " This browser records while it plays: on a slow computer pictures are left out.");
  };
  store.watch(["speed", "mode"], tell);
  for (const { track } of app.runs) if (track instanceof FramesTrack) track.onChange(tell);
  return menu("Video", "video", h("div", "rows", rate.element, legend.element, length, save, bar));
}
