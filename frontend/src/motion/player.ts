/** Clock: advances the state's time during playback. */

import type { Store } from "../state";
import type { Track } from "./track";
import { before } from "./track";

export class Player {
  private last: number | null = null;

  constructor(
    private store: Store,
    private tracks: () => Track[],
  ) {}

  get start(): number {
    return Math.min(...this.tracks().map((track) => track.start));
  }

  get end(): number {
    return Math.max(...this.tracks().map((track) => track.end));
  }

  play(): void {
    if (!(this.end > this.start)) return;
    const { time, loop } = this.store.state;
    this.last = null;
    this.store.set({ playing: true, ...(time >= this.end && !loop ? { time: this.start } : {}) });
  }

  pause(): void {
    this.store.set({ playing: false });
  }

  toggle(): void {
    if (this.store.state.playing) this.pause();
    else this.play();
  }

  /** Show the nearest available instant; resolves once its rows are loaded. */
  async seek(time: number): Promise<void> {
    this.store.set({ time: Math.max(this.start, Math.min(this.end, time)) });
    await this.ready();
  }

  /** Step some frames forward or back; pauses. */
  step(count: number): void {
    const { times } = this.tracks()[0];
    const { time } = this.store.state;
    this.pause();
    if (times.length < 2) {
      void this.seek(time + (count * (this.end - this.start)) / 48);
      return;
    }
    const i = before(times, time);
    // between frames, a step back goes to the earlier frame
    const between = time > times[i] && count < 0 ? 1 : 0;
    void this.seek(times[Math.max(0, Math.min(times.length - 1, i + count + between))]);
  }

  /** Resolves once the rows of the displayed instant are loaded. */
  async ready(): Promise<void> {
    const { time } = this.store.state;
    await Promise.all(this.tracks().map((track) => track.ready(time)));
  }

  /** Advance to a real time, s; a long pause between pictures counts as 0.1 s. */
  tick(now: number): void {
    if (!this.store.state.playing) {
      this.last = null;
      return;
    }
    const passed = this.last === null ? 0 : Math.min(0.1, now - this.last);
    this.last = now;
    const { time, speed, loop } = this.store.state;
    const { start, end } = this;
    let next = time + speed * passed;
    let playing = true;
    if (next > end || next < start) {
      if (loop && end > start) next = start + ((((next - start) % (end - start)) + (end - start)) % (end - start));
      else {
        next = next > end ? end : start;
        playing = false;
      }
    }
    this.store.set({ time: next, playing });
  }
}
