/** Light or dark: as the system is, or as chosen. */

import type { State } from "../state";
import type { Kit } from "./kit";

const NAME = "jousto-theme";

/** What was chosen before, where the browser keeps it. */
function kept(): State["theme"] {
  try {
    const value = localStorage.getItem(NAME);
    return value === "light" || value === "dark" ? value : "auto";
  } catch {
    return "auto";
  }
}

export function mountTheme(kit: Kit): void {
  const { store } = kit.app;
  const system = matchMedia("(prefers-color-scheme: dark)");
  const apply = (): void => {
    const { theme } = store.state;
    const dark = theme === "auto" ? system.matches : theme === "dark";
    document.documentElement.dataset["theme"] = dark ? "dark" : "light";
    kit.app.view.redraw();
  };
  store.set({ theme: kept() });
  system.addEventListener("change", apply);
  store.watch(["theme"], ({ theme }) => {
    apply();
    try {
      localStorage.setItem(NAME, theme);
    } catch {
      // pages from disk may not keep anything
    }
  });
}

/** The next of the three. */
export function nextTheme(kit: Kit): void {
  const { store } = kit.app;
  const order: State["theme"][] = ["auto", "light", "dark"];
  store.set({ theme: order[(order.indexOf(store.state.theme) + 1) % 3] });
}
