/** Light or dark theme: the system's or a chosen one. */

import type { State } from "../state";
import type { Kit } from "./kit";

const NAME = "jousto-theme";

/** Earlier choice, if the browser has stored it. */
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
      // pages from disk may have no storage
    }
  });
}

/** Next choice: the opposite of the system's theme, or the system's theme. */
export function nextTheme(kit: Kit): void {
  const { store } = kit.app;
  const system: State["theme"] = matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light";
  const other: State["theme"] = system === "dark" ? "light" : "dark";
  store.set({ theme: store.state.theme === other ? "auto" : other });
}
