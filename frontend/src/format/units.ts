/** Display units: SI values with a suitable prefix. */

export interface Unit {
  label: string;
  /** Shown value = SI value * factor. */
  factor: number;
}

/** From the smallest unit to the largest. */
const PREFIXES: Record<string, Unit[]> = {
  Pa: [
    { label: "Pa", factor: 1 },
    { label: "kPa", factor: 1e-3 },
    { label: "MPa", factor: 1e-6 },
    { label: "GPa", factor: 1e-9 },
  ],
  m: [
    { label: "µm", factor: 1e6 },
    { label: "mm", factor: 1e3 },
    { label: "m", factor: 1 },
    { label: "km", factor: 1e-3 },
  ],
  s: [
    { label: "µs", factor: 1e6 },
    { label: "ms", factor: 1e3 },
    { label: "s", factor: 1 },
  ],
};
for (const base of ["N", "N m", "W", "J", "Hz", "N/m", "V"]) {
  PREFIXES[base] = [
    { label: base, factor: 1 },
    { label: `k${base}`, factor: 1e-3 },
    { label: `M${base}`, factor: 1e-6 },
  ];
}

/*Smallest largest value, in multiples of a unit, for which the prefix of the unit is used. */
const FROM: Record<string, number> = { Pa: 1, kPa: 0.1, MPa: 0.1, GPa: 100, km: 10, kHz: 10, m: 1, mm: 0.1 };

/** Return a readable unit for values up to `size` (SI) of a quantity. */
export function unitFor(unit: string, size: number): Unit {
  const list = PREFIXES[unit];
  if (!list) return { label: unit === "1" ? "" : unit, factor: 1 };
  const largest = Math.abs(size);
  if (!(largest > 0) || !Number.isFinite(largest)) return list.find(usual(unit)) ?? list[0];
  let found = list[0];
  for (const candidate of list) {
    if (largest * candidate.factor >= (FROM[candidate.label] ?? 1)) found = candidate;
  }
  return found;
}

const usual =
  (unit: string) =>
  (candidate: Unit): boolean =>
    candidate.label === ({ Pa: "MPa", m: "mm" }[unit] ?? unit);

/** Return a readable unit for a list of SI values; NaN is ignored. */
export function unitOf(unit: string, values: Iterable<number>): Unit {
  let size = 0;
  for (const value of values) if (Number.isFinite(value)) size = Math.max(size, Math.abs(value));
  return unitFor(unit, size);
}

/** Return a number with given significant digits, without powers of ten where possible. */
export function number(value: number | null | undefined, digits = 4): string {
  if (value === null || value === undefined || Number.isNaN(value)) return "–";
  if (!Number.isFinite(value)) return value > 0 ? "∞" : "−∞";
  if (value === 0) return "0";
  const size = Math.abs(value);
  let text: string;
  if (size >= 1e6 || size < 1e-4) text = power(value, digits);
  else {
    const places = Math.max(0, digits - 1 - Math.floor(Math.log10(size)));
    text = value.toFixed(Math.min(places, 12));
    if (Number(text) === 0) text = "0";
  }
  return text.replace("-", "−");
}

/** Return a round number of a scale without trailing zeros. */
export function mark(value: number, digits = 6): string {
  const text = number(value, digits);
  return text.includes(".") ? text.replace(/\.?0+(?=$|·)/, "") : text;
}

function power(value: number, digits: number): string {
  const [mantissa, exponent] = value.toExponential(Math.max(0, digits - 1)).split("e");
  return `${mantissa}·10${superscript(String(Number(exponent)))}`;
}

function superscript(text: string): string {
  return [...text].map((c) => (c === "-" ? "⁻" : "⁰¹²³⁴⁵⁶⁷⁸⁹"[Number(c)])).join("");
}

/*Return a reading; rounding errors become 0. */
export function reading(value: number, floor: number): number {
  return Math.abs(value) <= floor ? 0 : value;
}

/** Return a value with its unit: `12.3 MPa`. */
export function quantity(value: number | null | undefined, unit: string, digits = 4): string {
  if (value === null || value === undefined || Number.isNaN(value)) return "–";
  const shown = unitFor(unit, value);
  return `${number(value * shown.factor, digits)}${shown.label ? ` ${shown.label}` : ""}`;
}

/** Return a number with given decimals; zero has no sign. */
export function fixed(value: number, places: number): string {
  const text = value.toFixed(places);
  return (Number(text) === 0 ? text.replace("-", "") : text).replace("-", "−");
}

/** Return an instant of a run with the decimals that the frame interval requires. */
export function clock(time: number, spacing: number): string {
  const places = spacing > 0 ? Math.ceil(-Math.log10(spacing) - 1e-9) : 3;
  return fixed(time, Math.min(Math.max(places, 0), 6));
}
