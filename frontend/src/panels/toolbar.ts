/** Title and main buttons. */

import { button, download, fileName, h, press } from "./dom";
import { pictureMenu, videoMenu } from "./exports";
import { icon } from "./icons";
import type { Kit } from "./kit";
import { tried } from "./kit";
import { nextTheme } from "./theme";

export function mountToolbar(kit: Kit, help: () => void): void {
  const { app } = kit;
  const { store, slots, view, source } = app;
  const { scene } = app.runs[0];
  const narrow = window.innerWidth <= 900;
  slots.root.classList.toggle("no-left", narrow);
  slots.root.classList.toggle("no-right", narrow);
  const side = (name: "left" | "right", label: string, symbol: string): HTMLButtonElement => {
    const other = name === "left" ? "right" : "left";
    const made = button(label, () => {
      const hidden = slots.root.classList.toggle(`no-${name}`);
      if (!hidden && window.innerWidth <= 900) slots.root.classList.add(`no-${other}`);
      sides.forEach(([which, element]) => press(element, !slots.root.classList.contains(`no-${which}`)));
    }, { icon: symbol });
    press(made, !narrow);
    return made;
  };
  const left = side("left", "Bodies, joints, sensors", "tree");
  const right = side("right", "Colours, numbers, display", "tune");
  const sides = [["left", left], ["right", right]] as const;

  const measure = button(
    "Measure a distance",
    () => store.set({ tool: store.state.tool === "measure" ? "select" : "measure" }),
    { icon: "measure", key: "M" },
  );
  store.watch(["tool"], ({ tool }) => press(measure, tool === "measure"));
  const theme = button("Light or dark", () => nextTheme(kit), { icon: "auto", key: "D" });
  store.watch(["theme"], (state) => {
    const words = { auto: "as the system", light: "light", dark: "dark" };
    theme.replaceChildren(icon({ auto: "auto", light: "sun", dark: "moon" }[state.theme]));
    theme.title = `Colours of the page: ${words[state.theme]} (D)`;
  });
  const title = scene.title || scene.name;
  document.title = `${title} · jousto`;
  const moves = app.player.end > app.player.start && !source.live;
  slots.top.append(
    left,
    h("h1", { text: title, title }),
    h("span", "grow"),
    button("Fit", () => view.fit(), { icon: "fit", key: "F" }),
    measure,
    pictureMenu(kit),
    moves ? videoMenu(kit) : "",
    source.exact && !source.live ? button("Save this page as one file", () => void save(kit), { icon: "save" }) : "",
    theme,
    button("Keys and mouse", help, { icon: "help", key: "?" }),
    right,
  );
  if (!narrow) return;
  // touching the picture closes panels
  view.canvas.addEventListener("pointerdown", () => {
    for (const [name, element] of sides) {
      slots.root.classList.add(`no-${name}`);
      press(element, false);
    }
  });
}

/** Let the server write a self-contained file. */
async function save(kit: Kit): Promise<void> {
  kit.say("The page is being made …");
  const address = new URL("page.html", window.location.href);
  address.search = window.location.search;
  const answer = await tried(kit, fetch(address));
  if (!answer) return;
  if (!answer.ok) {
    kit.say((await answer.text()) || "The page could not be made.", "error");
    return;
  }
  const name = fileName(kit.app.runs[0].scene.title || kit.app.runs[0].scene.name, "html");
  const data = await answer.blob();
  download(name, data);
  kit.say(`${name} (${(data.size / 1e6).toFixed(1)} MB) opens in any browser, without jousto.`);
}
