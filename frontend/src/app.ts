/** What every panel and tool gets: the state, the runs, the view and the places for panels. */

import type { Scene } from "./protocol";
import type { Source } from "./source/source";
import type { Player } from "./motion/player";
import type { Track } from "./motion/track";
import type { View } from "./render/view";
import type { Slots } from "./slots";
import type { Store } from "./state";

/** A run: what does not change and the rows of its instants. */
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
  /** Called with the scene of a running machine when a parameter has changed it. */
  renewed: Set<(scene: Scene) => void>;
}
