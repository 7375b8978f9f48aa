/** WebM video, encoded frame by frame, so that its content does not depend on the computer's speed. */

import type { App } from "../app";
import { legendLook, pressureLook } from "../panels/legend";
import { caption, dress } from "./compose";
import { isDark } from "./picture";
import type { Picture } from "./webm";
import { webm } from "./webm";

export interface VideoOptions {
  /** Frames per second of the video. */
  rate: number;
  /** Machine time per video time. */
  speed: number;
  start: number;
  end: number;
  legend: boolean;
  progress: (share: number) => void;
  cancelled: () => boolean;
}

/** Instants of the frames. */
export function instants(start: number, end: number, speed: number, rate: number): number[] {
  const count = Math.max(1, Math.floor(((end - start) / speed) * rate + 1e-9) + 1);
  return Array.from({ length: count }, (_, i) => Math.min(end, start + (i * speed) / rate));
}

/** Whether this browser has a frame encoder (WebCodecs). */
export const encodes = (): boolean => typeof VideoEncoder === "function" && typeof VideoFrame === "function";

const CODECS = [
  { codec: "vp09.00.40.08", name: "V_VP9" },
  { codec: "vp8", name: "V_VP8" },
] as const;

export async function video(app: App, options: VideoOptions): Promise<Blob | null> {
  const canvas = document.createElement("canvas");
  const [w, h] = [app.view.canvas.width & ~1, app.view.canvas.height & ~1];
  canvas.width = w;
  canvas.height = h;
  const ctx = canvas.getContext("2d")!;
  const k = w / app.view.canvas.clientWidth;
  const draw = async (time: number): Promise<void> => {
    await app.player.seek(time);
    app.view.drawNow();
    ctx.drawImage(app.view.canvas, 0, 0);
    const [legend, title] = options.legend ? [legendLook(app) ?? pressureLook(app), caption(app)] : [null, ""];
    dress(ctx, h, k, { legend, title, dark: isDark(), ends: app.view.axisEnds });
  };
  const before = app.store.state;
  app.player.pause();
  try {
    return encodes() ? await encoded(canvas, draw, options) : await recorded(canvas, draw, options);
  } finally {
    app.store.set({ time: before.time, playing: before.playing });
  }
}

async function encoded(
  canvas: HTMLCanvasElement,
  draw: (time: number) => Promise<void>,
  options: VideoOptions,
): Promise<Blob | null> {
  const { width, height } = canvas;
  const bitrate = Math.min(24e6, Math.max(2e6, 0.15 * width * height * options.rate));
  const base = { width, height, bitrate, framerate: options.rate };
  let chosen: (typeof CODECS)[number] | null = null;
  for (const one of CODECS) {
    const { supported } = await VideoEncoder.isConfigSupported({ ...base, codec: one.codec });
    if (supported) {
      chosen = one;
      break;
    }
  }
  if (!chosen) throw new Error("This browser encodes neither VP9 nor VP8: make the video in Chromium or Firefox.");
  const pictures: Picture[] = [];
  let failure: Error | null = null;
  const encoder = new VideoEncoder({
    output: (chunk) => {
      const data = new Uint8Array(chunk.byteLength);
      chunk.copyTo(data);
      pictures.push({ data, time: chunk.timestamp / 1000, key: chunk.type === "key" });
    },
    error: (error) => (failure = error),
  });
  encoder.configure({ ...base, codec: chosen.codec, latencyMode: "quality" });
  const step = 1000 / options.rate;
  const all = instants(options.start, options.end, options.speed, options.rate);
  for (const [i, time] of all.entries()) {
    if (options.cancelled()) {
      encoder.close();
      return null;
    }
    await draw(time);
    const frame = new VideoFrame(canvas, { timestamp: Math.round(i * step * 1000), duration: Math.round(step * 1000) });
    encoder.encode(frame, { keyFrame: i % Math.round(4 * options.rate) === 0 });
    frame.close();
    options.progress((i + 1) / all.length);
    // let the page respond, and the encoder queue empty
    do await new Promise((resolve) => setTimeout(resolve, encoder.encodeQueueSize > 4 ? 10 : 0));
    while (encoder.encodeQueueSize > 4);
    if (failure) throw failure;
  }
  await encoder.flush();
  encoder.close();
  return new Blob(webm(chosen.name, width, height, step, pictures) as BlobPart[], { type: "video/webm" });
}

/** Without WebCodecs: recording in real time; a slow computer drops frames. */
async function recorded(
  canvas: HTMLCanvasElement,
  draw: (time: number) => Promise<void>,
  options: VideoOptions,
): Promise<Blob | null> {
  if (typeof MediaRecorder !== "function" || !MediaRecorder.isTypeSupported("video/webm")) {
    throw new Error("This browser cannot make WebM videos: make the video in Chromium or Firefox.");
  }
  const recorder = new MediaRecorder(canvas.captureStream(options.rate), { mimeType: "video/webm", videoBitsPerSecond: 12e6 });
  const parts: Blob[] = [];
  recorder.ondataavailable = ({ data }) => parts.push(data);
  const stopped = new Promise((resolve) => (recorder.onstop = resolve));
  await draw(options.start);
  recorder.start();
  const began = performance.now();
  const length = (options.end - options.start) / options.speed;
  for (;;) {
    const passed = (performance.now() - began) / 1000;
    if (options.cancelled() || passed > length) break;
    await draw(options.start + options.speed * passed);
    options.progress(passed / length);
    await new Promise(requestAnimationFrame);
  }
  recorder.stop();
  await stopped;
  return options.cancelled() ? null : new Blob(parts, { type: "video/webm" });
}
