/** Mouse, pen and touch input on the picture: orbit, pan, zoom, clicks and drags. */

import type { Rig } from "./camera";

export interface Gestures {
  click(x: number, y: number, event: PointerEvent): void;
  double(x: number, y: number): void;
  hover(x: number, y: number): void;
  leave(): void;
  /** Whether a tool takes the drag that starts here; `drag` then replaces orbit. */
  grab(x: number, y: number): boolean;
  drag(phase: "move" | "end", x: number, y: number): void;
}

interface Finger {
  x: number;
  y: number;
}

const SLACK = 4; // pixels by which the pointer may move during a click
const ORBIT = 0.0065; // rad a pixel

/** Move the camera by gestures on an element; calls `moved` after each move. */
export function control(element: HTMLElement, rig: Rig, gestures: Gestures, moved: () => void): void {
  const fingers = new Map<number, Finger>();
  let mode: "orbit" | "pan" | "grab" | null = null;
  let travelled = 0;

  const at = (event: MouseEvent): [number, number] => {
    const box = element.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  };

  element.addEventListener("contextmenu", (event) => event.preventDefault());

  element.addEventListener("pointerdown", (event) => {
    const [x, y] = at(event);
    element.setPointerCapture(event.pointerId);
    element.focus({ preventScroll: true });
    fingers.set(event.pointerId, { x, y });
    if (fingers.size > 1) {
      if (mode === "grab") gestures.drag("end", x, y);
      mode = "pan";
      return;
    }
    travelled = 0;
    const shift = event.button === 1 || event.button === 2 || event.shiftKey;
    mode = shift ? "pan" : gestures.grab(x, y) ? "grab" : "orbit";
  });

  element.addEventListener("pointermove", (event) => {
    const [x, y] = at(event);
    const finger = fingers.get(event.pointerId);
    if (!finger) {
      gestures.hover(x, y);
      return;
    }
    const dx = x - finger.x, dy = y - finger.y;
    travelled += Math.abs(dx) + Math.abs(dy);
    if (fingers.size === 2) {
      const other = [...fingers].find(([id]) => id !== event.pointerId)![1];
      const before = Math.hypot(finger.x - other.x, finger.y - other.y);
      const after = Math.hypot(x - other.x, y - other.y);
      rig.pan(dx / 2, dy / 2);
      if (before > 0 && after > 0) {
        rig.zoom(before / after, (x + other.x) / 2 - rig.width / 2, (y + other.y) / 2 - rig.height / 2);
      }
      moved();
    } else if (mode === "grab") {
      gestures.drag("move", x, y);
    } else if (travelled > SLACK) {
      if (mode === "orbit") rig.orbit(dx * ORBIT, dy * ORBIT);
      else rig.pan(dx, dy);
      moved();
    }
    finger.x = x;
    finger.y = y;
  });

  const release = (event: PointerEvent): void => {
    if (!fingers.delete(event.pointerId)) return;
    const [x, y] = at(event);
    if (mode === "grab") gestures.drag("end", x, y);
    else if (event.type === "pointerup" && travelled <= SLACK && mode === "orbit") gestures.click(x, y, event);
    mode = fingers.size ? "orbit" : null;
    travelled = SLACK + 1;
  };
  element.addEventListener("pointerup", release);
  element.addEventListener("pointercancel", release);
  element.addEventListener("pointerleave", () => gestures.leave());
  element.addEventListener("dblclick", (event) => gestures.double(...at(event)));

  element.addEventListener(
    "wheel",
    (event) => {
      event.preventDefault();
      const lines = event.deltaMode === 1 ? 30 : 1;
      const [x, y] = at(event);
      const factor = Math.exp(Math.max(-240, Math.min(240, event.deltaY * lines)) * 0.0016);
      rig.zoom(factor, x - rig.width / 2, y - rig.height / 2);
      moved();
    },
    { passive: false },
  );
}
