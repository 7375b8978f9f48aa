/** Scalar measures of a stress tensor `[s11 s22 s33 s12 s23 s13]`. */

export const COMPONENTS = ["s11", "s22", "s33", "s12", "s23", "s13"] as const;

/** Measures of stress in the shader's order, after the components. */
export const STRESSES = [...COMPONENTS, "von-mises", "signed-von-mises", "principal-max", "principal-min"] as const;

export function vonMises(s: ArrayLike<number>, at = 0): number {
  const a = s[at], b = s[at + 1], c = s[at + 2], d = s[at + 3], e = s[at + 4], f = s[at + 5];
  const direct = (a - b) ** 2 + (b - c) ** 2 + (c - a) ** 2;
  return Math.sqrt(0.5 * direct + 3 * (d * d + e * e + f * f));
}

/** Principal stresses, the largest first, from the angle of the deviator (Lode). */
export function principal(s: ArrayLike<number>, at = 0): [number, number, number] {
  const mean = (s[at] + s[at + 1] + s[at + 2]) / 3;
  const a = s[at] - mean, b = s[at + 1] - mean, c = s[at + 2] - mean;
  const d = s[at + 3], e = s[at + 4], f = s[at + 5];
  const q = Math.sqrt((a * a + b * b + c * c + 2 * (d * d + e * e + f * f)) / 6);
  if (q === 0) return [mean, mean, mean];
  const third = a * (b * c - e * e) - d * (d * c - e * f) + f * (d * e - b * f);
  const angle = Math.acos(Math.max(-1, Math.min(1, third / (2 * q ** 3)))) / 3;
  const first = 2 * q * Math.cos(angle);
  const last = 2 * q * Math.cos(angle + (2 * Math.PI) / 3);
  return [mean + first, mean - first - last, mean + last];
}

/** Share of the difference of the extreme principal stresses below which their sum is rounding (pure shear). */
const SUM_ROUNDING = 1e-7;

/** Measure of stress by its name; NaN for an unknown name. */
export function measure(name: string, s: ArrayLike<number>, at = 0): number {
  const component = (COMPONENTS as readonly string[]).indexOf(name);
  if (component >= 0) return s[at + component];
  if (name === "von-mises") return vonMises(s, at);
  const [first, , last] = principal(s, at);
  if (name === "principal-max") return first;
  if (name === "principal-min") return last;
  if (name === "signed-von-mises") return (first + last >= -SUM_ROUNDING * (first - last) ? 1 : -1) * vonMises(s, at);
  return NaN;
}
