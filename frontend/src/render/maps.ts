/** Colour maps: colours by share of the range. */

/** Stops of the maps, evenly spaced, sRGB. */
const STOPS: Record<string, string[]> = {
  // rainbow order with less glaring ends
  spectrum: ["#2b3a9e", "#2f6fd0", "#2fa5cf", "#36bf94", "#8fce4a", "#e3cf3a", "#f5a12c", "#e5602b", "#bd1f2d"],
  // uniform steps of lightness, readable with red blindness
  even: ["#161a4a", "#2b3f80", "#2e6a93", "#2f938f", "#58b77a", "#a3d15f", "#f3e45c"],
  // for signed measures: pale in the middle
  signed: ["#1f4e9c", "#4f86c6", "#9dbfe0", "#eceef0", "#eeb39a", "#d4694f", "#9e1f2c"],
  grey: ["#2a2e34", "#8a9098", "#e8ebee"],
};

export const MAPS = Object.keys(STOPS);

type Colour = [number, number, number];

const parse = (text: string): Colour =>
  [1, 3, 5].map((at) => parseInt(text.slice(at, at + 2), 16)) as Colour;

const linear = (c: number): number => {
  const x = c / 255;
  return x <= 0.04045 ? x / 12.92 : ((x + 0.055) / 1.055) ** 2.4;
};

const encoded = (x: number): number =>
  255 * (x <= 0.0031308 ? 12.92 * x : 1.055 * x ** (1 / 2.4) - 0.055);

/** Mixing in Oklab (Ottosson, 2020), in which straight lines are perceptually uniform. */
function toLab(colour: Colour): Colour {
  const [r, g, b] = colour.map(linear);
  const l = Math.cbrt(0.4122214708 * r + 0.5363325363 * g + 0.0514459929 * b);
  const m = Math.cbrt(0.2119034982 * r + 0.6806995451 * g + 0.1073969566 * b);
  const s = Math.cbrt(0.0883024619 * r + 0.2817188376 * g + 0.6299787005 * b);
  return [
    0.2104542553 * l + 0.793617785 * m - 0.0040720468 * s,
    1.9779984951 * l - 2.428592205 * m + 0.4505937099 * s,
    0.0259040371 * l + 0.7827717662 * m - 0.808675766 * s,
  ];
}

function fromLab([L, a, b]: Colour): Colour {
  const l = (L + 0.3963377774 * a + 0.2158037573 * b) ** 3;
  const m = (L - 0.1055613458 * a - 0.0638541728 * b) ** 3;
  const s = (L - 0.0894841775 * a - 1.291485548 * b) ** 3;
  return [
    4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s,
    -1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s,
    -0.0041960863 * l - 0.7034186147 * m + 1.707614701 * s,
  ].map((x) => Math.max(0, Math.min(255, encoded(x)))) as Colour;
}

/** Colour at a share 0 to 1 of the range, 0 to 255 each. */
export function colourAt(map: string, share: number): Colour {
  const stops = STOPS[map] ?? STOPS["spectrum"];
  const x = Math.max(0, Math.min(1, share)) * (stops.length - 1);
  const i = Math.min(Math.floor(x), stops.length - 2);
  const a = toLab(parse(stops[i])), b = toLab(parse(stops[i + 1]));
  return fromLab(a.map((value, k) => value + (x - i) * (b[k] - value)) as Colour);
}

/** n colours from the lowest to the highest value. */
export function ramp(map: string, n: number): Colour[] {
  return Array.from({ length: n }, (_, i) => colourAt(map, n > 1 ? i / (n - 1) : 0.5));
}
