/** Slots of the page: picture in the middle, panels around it, labels over it. */

export interface Slots {
  root: HTMLElement;
  /** Title and main buttons. */
  top: HTMLElement;
  /** Tree of the machine. */
  left: HTMLElement;
  /** Properties, contours, plots. */
  right: HTMLElement;
  /** Time line. */
  bottom: HTMLElement;
  /** Picture with the canvas. */
  stage: HTMLElement;
  /** Overlay; passes mouse events except to children that request them. */
  overlay: HTMLElement;
}

function place(parent: HTMLElement, tag: string, name: string): HTMLElement {
  const element = document.createElement(tag);
  element.className = name;
  parent.append(element);
  return element;
}

export function slots(parent: HTMLElement): Slots {
  const root = place(parent, "div", "jousto");
  const top = place(root, "header", "slot-top");
  const left = place(root, "aside", "slot-left");
  const stage = place(root, "main", "slot-stage");
  const right = place(root, "aside", "slot-right");
  const bottom = place(root, "footer", "slot-bottom");
  const overlay = place(stage, "div", "overlay");
  return { root, top, left, right, bottom, stage, overlay };
}
