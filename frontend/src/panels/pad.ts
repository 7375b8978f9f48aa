/** Gamepad control of inputs: each stick axis sets the position within an input's range. */

import type { Input } from "../protocol";

const REST = 0.12; // share of the range within which a released stick counts as zero

/** Input value of a stick at `x` (-1 to 1); `rest` is the initial value. */
export function stick(input: Input, x: number, rest: number): number {
  const size = Math.max(0, (Math.abs(x) - REST) / (1 - REST));
  return x < 0 ? rest - size * (rest - input.low) : rest + size * (input.high - rest);
}

export function mountPad(
  inputs: readonly Input[],
  set: (k: number, value: number) => void,
  found: (name: string) => void,
): void {
  const rest = inputs.map((input) => input.value);
  const moved = inputs.map(() => false);
  let polling = false;
  const poll = (): void => {
    const pad = navigator.getGamepads().find((candidate) => candidate !== null);
    if (!pad) {
      polling = false;
      return;
    }
    inputs.forEach((input, k) => {
      if (k >= pad.axes.length) return;
      // vertical axes: upward is positive
      const x = k % 2 ? -pad.axes[k] : pad.axes[k];
      const away = Math.abs(x) > REST;
      if (away || moved[k]) set(k, stick(input, x, rest[k]));
      moved[k] = away;
    });
    requestAnimationFrame(poll);
  };
  window.addEventListener("gamepadconnected", (event) => {
    found(event.gamepad.id);
    if (!polling) requestAnimationFrame(poll);
    polling = true;
  });
}
