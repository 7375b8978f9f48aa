/** Context of every panel and tool: state, runs, view and slots. */

import type { Scene } from "./protocol";
import type { Source } from "./source/source";
import type { Player } from "./motion/player";
import type { Track } from "./motion/track";
import type { View } from "./render/view";
import type { Slots } from "./slots";
import type { Store } from "./state";

/** Run: its scene and the rows of its instants. */
export interface Run {
  index: number;
  title: string;
  scene: Scene;
  track: Track;
}

export interface App {
  store: Store;
  source: Source;
  runs: Run[];
  view: View;
  player: Player;
  slots: Slots;
  /** Called with the new scene of a running machine after a parameter change. */
  renewed: Set<(scene: Scene) => void>;
}
