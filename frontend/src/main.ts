/** The page: opens its data, makes the app and mounts the panels. */

import type { App, Run } from "./app";
import { Player } from "./motion/player";
import { thicken } from "./motion/thicken";
import { LiveTrack, ModeTrack, makeTrack } from "./motion/track";
import { mountPanels } from "./panels/index";
import { View } from "./render/view";
import type { Scene } from "./protocol";
import { slots } from "./slots";
import { EngineSource, isMachine } from "./source/engine";
import { FileSource, unpack } from "./source/file";
import { kept } from "./source/said";
import { SocketSource } from "./source/socket";
import type { Source } from "./source/source";
import { Store, initial } from "./state";

async function openSource(store: Store): Promise<Source> {
  const data = document.getElementById("jousto-data");
  if (data) {
    const content = await unpack(data.textContent);
    data.remove(); // its text needs as much memory as the data
    return isMachine(content) ? EngineSource.open(content) : new FileSource(content);
  }
  return SocketSource.open((message) => store.set({ playing: false, message }));
}

async function openRuns(source: Source): Promise<Run[]> {
  const first = await source.scene(0);
  const titles = first.runs ?? [first.title];
  const scenes = [first, ...(await Promise.all(titles.slice(1).map((_, k) => source.scene(k + 1))))];
  scenes.forEach(thicken);
  return scenes.map((scene, index) => ({
    index,
    title: titles[index],
    scene,
    track: makeTrack(source, scene, index),
  }));
}

async function open(parent: HTMLElement): Promise<App> {
  const store = new Store(initial());
  const source = await openSource(store);
  const runs = await openRuns(source);
  const { scene, track } = runs[0];
  const period = track instanceof ModeTrack ? track.end : 1;
  store.set({
    time: track.start,
    runs: runs.map(() => true),
    // modes play with a period of two seconds
    speed: track instanceof ModeTrack ? period / 2 : 1,
    measure: scene.measures.includes("von-mises") && scene.what === "run" ? "von-mises" : null,
  });
  const player = new Player(store, () => runs.map((run) => run.track));
  const places = slots(parent);
  const view = new View(places.stage, store, runs, player, source);
  const app: App = { store, source, runs, view, player, slots: places, renewed: new Set() };
  if (track instanceof ModeTrack) {
    let shown = -1;
    store.watch(["mode"], ({ mode }) => {
      if (mode === shown) return;
      shown = mode;
      track.choose(mode);
      store.set({ time: 0, speed: track.end / 2 });
    });
  }
  let version: number | undefined;
  source.onLive((live) => {
    if (version !== undefined && live.scene !== undefined && live.scene !== version) {
      source.scene(0).then(
        (changed) => {
          // a machine with other objects needs a new page
          if (listed(changed) !== listed(runs[0].scene)) window.location.reload();
          thicken(changed);
          runs[0].scene = changed;
          view.build(runs[0], 0);
          for (const call of app.renewed) call(changed);
        },
        (error: unknown) => store.set({ message: (error as Error).message }),
      );
    }
    version = live.scene;
    if (track instanceof LiveTrack) track.push(live.time, live.row.data);
    store.set({ time: live.time });
  });
  const say = mountPanels(app);
  const said = kept();
  if (said) say(said);
  for (const { scene: shown } of runs) if (shown.note) say(`${shown.note}.`, "error");
  await player.ready();
  view.drawNow();
  if (window.location.hash === "#play") player.play();
  return app;
}

/** Content of a scene by name. */
const listed = (scene: Scene): string =>
  JSON.stringify([scene.row, ...[scene.bodies, scene.symbols, scene.sensors].map((list) => list.map(({ name }) => name))]);

/** For tests: displayed values as numbers. */
export interface Hooks {
  ready: Promise<void>;
  app: App | null;
  project(body: number, vertex: number): [number, number] | null;
  pixel(x: number, y: number): [number, number, number];
  frame(): Promise<void>;
  setTime(time: number): Promise<void>;
  readonly counters: { frames: number; drawMs: number; heap: number };
}

function start(): void {
  const parent = document.getElementById("jousto") ?? document.body;
  const opened = open(parent);
  const hooks: Hooks = {
    ready: opened.then(() => undefined),
    app: null,
    project(body, vertex) {
      const at = hooks.app!.view.project(0, body, vertex);
      return at && [at[0], at[1]];
    },
    pixel: (x, y) => hooks.app!.view.pixel(x, y),
    frame: () => new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(() => resolve()))),
    async setTime(time) {
      await hooks.app!.player.seek(time);
      hooks.app!.view.drawNow();
    },
    get counters() {
      return hooks.app!.view.counters;
    },
  };
  (window as unknown as { jousto: Hooks }).jousto = hooks;
  opened.then(
    (app) => {
      hooks.app = app;
    },
    (error: unknown) => {
      const note = document.createElement("p");
      note.className = "failure";
      note.textContent = error instanceof Error ? error.message : String(error);
      parent.append(note);
    },
  );
}

start();
