/** PNG picture of the view. */

import type { App } from "../app";
import { legendLook, pressureLook } from "../panels/legend";
import { caption, dress } from "./compose";

export interface PictureOptions {
  /** Picture pixels per page pixel. */
  scale: number;
  legend: boolean;
  transparent: boolean;
}

export const isDark = (): boolean => document.documentElement.dataset["theme"] === "dark";

export async function picture(app: App, options: PictureOptions): Promise<Blob> {
  const { scale, legend, transparent } = options;
  const bare = await app.view.picture(scale, { transparent });
  const image = await createImageBitmap(bare);
  const canvas = document.createElement("canvas");
  canvas.width = image.width;
  canvas.height = image.height;
  const ctx = canvas.getContext("2d")!;
  ctx.drawImage(image, 0, 0);
  dress(ctx, canvas.height, image.width / app.view.canvas.clientWidth, {
    legend: legend ? (legendLook(app) ?? pressureLook(app)) : null,
    title: legend ? caption(app) : "",
    ends: app.view.axisEnds,
    dark: isDark() && !transparent,
  });
  return new Promise((resolve, reject) =>
    canvas.toBlob((blob) => (blob ? resolve(blob) : reject(new Error("The browser could not make the picture."))), "image/png"),
  );
}
