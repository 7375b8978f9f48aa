/** Icons as strokes on a grid of 20 by 20. */

const PATHS: Record<string, string> = {
  play: "M6 4l10 6-10 6z",
  pause: "M6 4v12M14 4v12",
  back: "M14 5l-7 5 7 5zM5 5v10",
  next: "M6 5l7 5-7 5zM15 5v10",
  loop: "M4 10a5 5 0 0 1 5-5h6M12 2l3 3-3 3M16 10a5 5 0 0 1-5 5H5M8 18l-3-3 3-3",
  fit: "M3 7V3h4M13 3h4v4M17 13v4h-4M7 17H3v-4M7 7h6v6H7z",
  tree: "M4 4h5v4H4zM11 9h5v3h-5zM11 14h5v3h-5zM6 8v8h5M6 10.500h5",
  tune: "M3 6h8M15 6h2M13 4v4M3 14h2M9 14h8M7 12v4",
  measure: "M3 13L13 3l4 4L7 17zM6 10l2 2M9 7l2 2",
  camera: "M3 6h3l1.500-2h5L14 6h3v10H3zM10 8a3 3 0 1 0 .01 0",
  video: "M3 5h9v10H3zM12 9l5-3v8l-5-3",
  sun: "M10 6a4 4 0 1 0 .01 0M10 1v2M10 17v2M1 10h2M17 10h2M4 4l1 1M15 15l1 1M16 4l-1 1M5 15l-1 1",
  moon: "M16 12A7 7 0 0 1 8 4a6.500 6.500 0 1 0 8 8z",
  auto: "M10 3a7 7 0 1 0 .01 0M10 3v14M10 6h4M10 9h6.500M10 12h6.500M10 15h4",
  help: "M10 2a8 8 0 1 0 .01 0M7.500 8a2.500 2.500 0 1 1 3.500 2.300c-.7.300-1 .8-1 1.700M10 14.500v.5",
  save: "M10 3v9M6 9l4 4 4-4M3 14v3h14v-3",
  eye: "M2 10s3-5 8-5 8 5 8 5-3 5-8 5-8-5-8-5zM10 8a2 2 0 1 0 .01 0",
  "eye-off": "M2 10s3-5 8-5 8 5 8 5-3 5-8 5-8-5-8-5zM3 17L17 3",
  ghost: "M10 3l6 3.500v7L10 17l-6-3.500v-7zM4 6.500l6 3.500 6-3.500M10 10v7",
  target: "M10 4a6 6 0 1 0 .01 0M10 1v5M10 14v5M1 10h5M14 10h5",
  close: "M5 5l10 10M15 5L5 15",
  more: "M4 10h.01M10 10h.01M16 10h.01",
  chart: "M3 3v14h14M6 13l3-5 3 3 4-6",
  view: "M10 2l7 4v8l-7 4-7-4V6zM3 6l7 4 7-4M10 10v8",
  zoom: "M8.500 3a5.500 5.500 0 1 0 .01 0M13 13l4 4M6 8.500h5M8.500 6v5",
  whole: "M3 5v10M17 5v10M5 10h10M7 8l-2 2 2 2M13 8l2 2-2 2",
  record: "M10 5a5 5 0 1 0 .01 0",
  reset: "M4 4v5h5M4.500 9A6 6 0 1 1 5 14",
  hand: "M6 10V5a1 1 0 0 1 2 0v4-5a1 1 0 0 1 2 0v5-4a1 1 0 0 1 2 0v5-3a1 1 0 0 1 2 0v5c0 3-2 5-5 5-3 0-4-2-6-5 0-1 1-2 3 0",
};

export function icon(name: string): SVGSVGElement {
  const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  svg.setAttribute("viewBox", "0 0 20 20");
  svg.setAttribute("aria-hidden", "true");
  svg.classList.add("icon");
  const path = document.createElementNS("http://www.w3.org/2000/svg", "path");
  path.setAttribute("d", PATHS[name] ?? PATHS.more);
  svg.append(path);
  return svg;
}
