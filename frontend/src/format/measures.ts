/** Names, units and explanations of the measures of colours and curves. */

interface Measure {
  label: string;
  unit: string;
  /** One-sentence explanation. */
  about: string;
}

const STRESS = "Pa";
const axis = ["1", "2", "3"];

const KNOWN: Record<string, Measure> = {
  "von-mises": { label: "Von Mises stress", unit: STRESS, about: "Equivalent stress of distortion." },
  "signed-von-mises": {
    label: "Signed von Mises stress",
    unit: STRESS,
    about: "Von Mises stress with the sign of the principal stress that is largest in size.",
  },
  "principal-max": { label: "Largest principal stress", unit: STRESS, about: "Tension is positive." },
  "principal-min": { label: "Smallest principal stress", unit: STRESS, about: "Compression is negative." },
  displacement: {
    label: "Displacement",
    unit: "m",
    about: "Elastic displacement relative to the body's frame, without amplification.",
  },
  damage: { label: "Damage", unit: "1", about: "Sum of Palmgren and Miner over the run; 1 is failure." },
  life: { label: "Life", unit: "s", about: "Time until damage 1 if the run is repeated." },
  ux: { label: "Displacement x", unit: "m", about: "Body frame." },
  uy: { label: "Displacement y", unit: "m", about: "Body frame." },
  uz: { label: "Displacement z", unit: "m", about: "Body frame." },
  x: { label: "Position x", unit: "m", about: "World frame." },
  y: { label: "Position y", unit: "m", about: "World frame." },
  z: { label: "Position z", unit: "m", about: "World frame." },
};
for (const [i, j] of [[0, 0], [1, 1], [2, 2], [0, 1], [1, 2], [0, 2]]) {
  const name = `s${axis[i]}${axis[j]}`;
  KNOWN[name] = {
    label: `${i === j ? "Normal" : "Shear"} stress ${axis[i]}${axis[j]}`,
    unit: STRESS,
    about: "Component in the axes of the body.",
  };
}

export function measure(name: string): Measure {
  return KNOWN[name] ?? { label: name, unit: "1", about: "" };
}

/** Whether the scale of a measure starts at zero: it is never negative. */
export const oneSided = (name: string): boolean =>
  ["von-mises", "displacement", "damage", "life"].includes(name);
