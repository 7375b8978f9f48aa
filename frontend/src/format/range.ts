/** Ranges of colours and axes. */

import { mark } from "./units";

/** Return about `count` round numbers from low to high: the ticks of a scale. */
export function ticks(low: number, high: number, count: number): number[] {
  if (!(high > low)) return [low];
  const raw = (high - low) / Math.max(1, count);
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = power * ([1, 2, 5, 10].find((m) => m * power >= raw * (1 - 1e-9)) ?? 10);
  const first = Math.ceil(low / step - 1e-9);
  const last = Math.floor(high / step + 1e-9);
  return Array.from({ length: last - first + 1 }, (_, i) => (first + i) * step + 0);
}

/** Return the range of two typed numbers, or a sentence on what is wrong with them. */
export function typed(low: string, high: string): [number, number] | string {
  const numbers = [low, high].map((text) => (text.trim() ? Number(text.replace(",", ".")) : NaN));
  if (numbers.some((value) => !Number.isFinite(value))) return "Lowest and highest value must be numbers.";
  if (!(numbers[0] < numbers[1])) return "The lowest value must be below the highest.";
  return [numbers[0], numbers[1]];
}

/** Return a window zoomed by a factor about an instant, within the whole. */
export function zoomed(
  window: readonly [number, number],
  whole: readonly [number, number],
  centre: number,
  factor: number,
): [number, number] {
  const length = Math.min((window[1] - window[0]) * factor, whole[1] - whole[0]);
  const share = (centre - window[0]) / (window[1] - window[0] || 1);
  const start = Math.min(Math.max(centre - share * length, whole[0]), whole[1] - length);
  return [start, start + length];
}

/** End of a range with three digits, or more if needed to differ from the other end. */
export function limit(value: number, span: number): string {
  if (Math.abs(value) < 1e-9 * Math.abs(span)) return "0";
  const more = span > 0 ? Math.floor(Math.log10(Math.abs(value))) - Math.floor(Math.log10(span)) : 0;
  return mark(value, Math.min(12, Math.max(3, more + 2)));
}
