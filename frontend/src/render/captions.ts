/** Letters of the axes in the corner, and the step of the grid. */

export class Captions {
  private letters: HTMLElement[];
  private step: HTMLElement;

  constructor(stage: HTMLElement, step: number) {
    const add = (name: string, text: string): HTMLElement => {
      const element = document.createElement("span");
      element.className = name;
      element.textContent = text;
      stage.append(element);
      return element;
    };
    this.letters = ["x", "y", "z"].map((letter) => add("axis-letter", letter));
    this.step = add("grid-step", `grid ${lengthText(step)}`);
  }

  /** Place the letters at the ends of the axes: pixels from the lower left corner. */
  place(ends: readonly (readonly [number, number])[], grid: boolean): void {
    this.letters.forEach((letter, k) => {
      letter.style.transform = `translate(${ends[k][0].toFixed(1)}px, ${(-ends[k][1]).toFixed(1)}px) translate(-50%, 50%)`;
    });
    this.step.hidden = !grid;
  }
}

/** Round length in mm, m or km. */
export function lengthText(metres: number): string {
  const [factor, unit] = metres < 0.1 ? [1e3, "mm"] : metres < 1000 ? [1, "m"] : [1e-3, "km"];
  return `${Number((metres * factor).toPrecision(6))} ${unit}`;
}
