/** Pulling with the mouse, with a line from the point to its target. */

import type { Vec3 } from "../protocol";
import type { Kit } from "./kit";

const NS = "http://www.w3.org/2000/svg";
const OFTEN = 15; // time between targets that are sent, ms

export function mountPull(kit: Kit, order: (what: Record<string, unknown>) => void): void {
  const { view, store, slots } = kit.app;
  const svg = document.createElementNS(NS, "svg");
  svg.classList.add("measure-line", "pull-line");
  const line = document.createElementNS(NS, "line");
  const end = document.createElementNS(NS, "circle");
  end.setAttribute("r", "4");
  svg.append(line, end);
  slots.overlay.append(svg);

  let held: { body: number; vertex: number } | null = null;
  let target: Vec3 = [0, 0, 0];
  let sent = 0;
  let later = 0;
  const send = (): void => {
    later = 0;
    if (!held) return;
    sent = performance.now();
    order({ do: "pull", ...held, point: target });
  };
  const draw = (): void => {
    const from = held && view.project(0, held.body, held.vertex);
    const to = held && view.at(target);
    svg.style.display = from && to ? "" : "none";
    if (!from || !to) return;
    for (const [name, value] of [["x1", from[0]], ["y1", from[1]], ["x2", to[0]], ["y2", to[1]]] as const) {
      line.setAttribute(name, value.toFixed(1));
    }
    end.setAttribute("cx", to[0].toFixed(1));
    end.setAttribute("cy", to[1].toFixed(1));
  };
  view.onDrag(({ phase, hit, point }) => {
    if (store.state.tool !== "pull") return;
    if (phase === "start") held = hit && { body: hit.body, vertex: hit.vertex };
    if (!held) return;
    target = Array.from(point) as Vec3;
    if (phase === "end") {
      clearTimeout(later);
      later = 0;
      held = null;
      order({ do: "release" });
    } else if (phase === "start") send();
    // send the last position without delay
    else later ||= window.setTimeout(send, Math.max(0, OFTEN - (performance.now() - sent)));
    draw();
    view.redraw();
  });
  view.onDraw(draw);
  draw();
}
