/** All panels and tools: one file each, with a function of the kit. */

import type { App } from "../app";
import { mountColours } from "./colours";
import { mountCompare } from "./compare";
import { mountDisplay } from "./display";
import { mountJoints } from "./joints";
import { mountKeys } from "./keys";
import type { Kit } from "./kit";
import { placeName } from "./kit";
import { mountLegend } from "./legend";
import { mountLive } from "./live";
import { mountMeasure } from "./measure";
import { mountModes } from "./modes";
import { Plots } from "./plots";
import { mountProbe } from "./probe";
import { mountSelection } from "./selection";
import { mountTheme } from "./theme";
import { mountTimeline } from "./timeline";
import type { Say } from "./toasts";
import { mountToasts } from "./toasts";
import { mountToolbar } from "./toolbar";
import { mountTree } from "./tree";
import { mountWorst } from "./worst";

export function mountPanels(app: App): Say {
  const say = mountToasts(app);
  const plots = new Plots(app, say, (place) => placeName(app, place));
  const kit: Kit = { app, say, plots };
  mountTheme(kit);
  if (!app.source.live) mountTimeline(kit);
  mountToolbar(kit, mountKeys(kit));
  mountTree(kit);
  mountModes(kit);
  mountJoints(kit);
  mountCompare(kit);
  mountColours(kit);
  mountSelection(kit);
  mountWorst(kit);
  mountDisplay(kit);
  mountLegend(kit);
  mountMeasure(kit);
  mountProbe(kit);
  mountLive(kit);
  // release the focus after mouse clicks: space plays, arrows step
  document.addEventListener("click", ({ detail, target }) => {
    const pressed = target instanceof Element ? target.closest<HTMLElement>("button, summary, label") : null;
    if (detail < 1 || !pressed) return;
    const box = pressed.querySelector<HTMLElement>("input[type=checkbox]");
    (box ?? pressed).blur();
  });
  return say;
}
