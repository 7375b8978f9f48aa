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

/** The other one: what the system does not want, or as the system is again. */
export function nextTheme(kit: Kit): void {
  const { store } = kit.app;
  const system: State["theme"] = matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light";
  const other: State["theme"] = system === "dark" ? "light" : "dark";
  store.set({ theme: store.state.theme === other ? "auto" : other });
}
