/** Messages at the edge of the picture, which disappear after a while; errors wait for a click. */

import type { App } from "../app";
import { button, h } from "./dom";

export type Say = (message: string, kind?: "note" | "error") => void;

export function mountToasts(app: App): Say {
  const box = h("div", { class: "toasts takes", attrs: { role: "status", "aria-live": "polite" } });
  app.slots.overlay.append(box);
  const say: Say = (message, kind = "note") => {
    const known = [...box.children].find((child) => child.querySelector("span")?.textContent === message);
    known?.remove();
    const toast = h("div", { class: `toast ${kind}` }, h("span", { text: message }));
    toast.append(button("Close message", () => toast.remove(), { icon: "close" }));
    box.append(toast);
    if (box.children.length > 4) box.firstElementChild?.remove();
    if (kind === "note") setTimeout(() => toast.remove(), 5000);
  };
  app.store.watch(["message"], (state) => {
    if (!state.message) return;
    say(state.message, "error");
    app.store.set({ message: "" });
  });
  window.addEventListener("unhandledrejection", (event) => {
    const reason: unknown = event.reason;
    say(reason instanceof Error ? reason.message : String(reason), "error");
  });
  return say;
}
