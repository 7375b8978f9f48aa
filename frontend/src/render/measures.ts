/** Indices of the measures in the shaders. */

import { STRESSES } from "../math/tensor";

/** Measures that are vertex attributes. */
export const ATTRIBUTE = 11;
const DISPLACEMENT = 10;

/** Index of a measure in the shader; -1 for plain colours. */
export function measureNumber(measure: string | null): number {
  if (measure === null) return -1;
  if (measure === "displacement") return DISPLACEMENT;
  const number = (STRESSES as readonly string[]).indexOf(measure);
  return number < 0 ? ATTRIBUTE : number;
}
