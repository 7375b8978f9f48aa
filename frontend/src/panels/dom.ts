/** One-line creation of elements, and the basic controls of all panels. */

import { icon } from "./icons";

type Child = Node | string | null | undefined | false;

interface Wanted {
  class?: string;
  text?: string;
  title?: string;
  /** HTML attributes. */
  attrs?: Record<string, string>;
  on?: { [K in keyof HTMLElementEventMap]?: (event: HTMLElementEventMap[K]) => void };
}

export function h<K extends keyof HTMLElementTagNameMap>(
  tag: K,
  wanted: Wanted | string = {},
  ...children: Child[]
): HTMLElementTagNameMap[K] {
  const element = document.createElement(tag);
  const w = typeof wanted === "string" ? { class: wanted } : wanted;
  if (w.class) element.className = w.class;
  if (w.text !== undefined) element.textContent = w.text;
  if (w.title) element.title = w.title;
  for (const [name, value] of Object.entries(w.attrs ?? {})) element.setAttribute(name, value);
  for (const [name, call] of Object.entries(w.on ?? {})) {
    element.addEventListener(name, call as EventListener);
  }
  element.append(...children.filter((child): child is Node | string => !!child));
  return element;
}

/** Button with an icon, a word or both; without a word the label is read aloud and shown on hover. */
export function button(
  label: string,
  call: (event: MouseEvent) => void,
  options: { icon?: string; text?: boolean; key?: string; class?: string } = {},
): HTMLButtonElement {
  const title = options.key ? `${label} (${options.key})` : label;
  const made = h("button", {
    class: `button ${options.class ?? ""}`,
    title,
    attrs: { type: "button", "aria-label": label },
    on: { click: call },
  });
  if (options.icon) made.append(icon(options.icon));
  if (options.text || !options.icon) made.append(h("span", { text: label }));
  return made;
}

/*Display a button as pressed or not. */
export function press(element: HTMLElement, on: boolean): void {
  element.setAttribute("aria-pressed", String(on));
}

export function toggle(label: string, call: (on: boolean) => void): {
  element: HTMLLabelElement;
  set: (on: boolean) => void;
} {
  const input = h("input", { attrs: { type: "checkbox", role: "switch" } });
  input.addEventListener("change", () => call(input.checked));
  const element = h("label", "row switch", h("span", { text: label }), input);
  return { element, set: (on) => void (input.checked = on) };
}

export function select(
  label: string,
  options: readonly (readonly [value: string, text: string])[],
  call: (value: string) => void,
): { element: HTMLLabelElement; input: HTMLSelectElement; set: (value: string) => void } {
  const input = h("select", { attrs: { "aria-label": label } });
  for (const [value, text] of options) input.append(h("option", { text, attrs: { value } }));
  input.addEventListener("change", () => call(input.value));
  const element = h("label", "row", h("span", { text: label }), input);
  return { element, input, set: (value) => void (input.value = value) };
}

/** Choices side by side, one of them selected. */
export function choice<T extends string>(
  label: string,
  options: readonly (readonly [value: T, text: string])[],
  call: (value: T) => void,
): { element: HTMLElement; set: (value: T) => void } {
  const element = h("div", { class: "choice", attrs: { role: "group", "aria-label": label } });
  const made = options.map(([value, text]) => {
    const one = button(text, () => call(value), { text: true });
    element.append(one);
    return [value, one] as const;
  });
  return { element, set: (value) => made.forEach(([v, one]) => press(one, v === value)) };
}

export interface Slider {
  element: HTMLElement;
  input: HTMLInputElement;
  set: (value: number) => void;
}

/** Slider with its value; `log`: its middle is the geometric mean of the ends. */
export function slider(
  label: string,
  range: { low: number; high: number; step?: number; log?: boolean },
  show: (value: number) => string,
  call: (value: number) => void,
): Slider {
  const to = (value: number): number => (range.log ? Math.log10(value) : value);
  const back = (x: number): number => (range.log ? 10 ** x : x);
  const [low, high] = [to(range.low), to(range.high)];
  const step = range.log ? (high - low) / 200 : (range.step ?? (high - low) / 200);
  const input = h("input", {
    attrs: { type: "range", min: `${low}`, max: `${high}`, step: `${step}`, "aria-label": label },
  });
  const output = h("output", "value");
  const tell = (value: number): void => {
    output.textContent = show(value);
    input.setAttribute("aria-valuetext", show(value));
    input.style.setProperty("--fill", `${((100 * (to(value) - low)) / (high - low || 1)).toFixed(1)}%`);
  };
  input.addEventListener("input", () => {
    const value = back(Number(input.value));
    tell(value);
    call(value);
  });
  const element = h("div", "slider", h("div", "row", h("span", { text: label }), output), input);
  return {
    element,
    input,
    set: (value) => {
      input.value = String(to(value));
      tell(value);
    },
  };
}

/** Section of a side panel under a heading that folds it. */
export function section(
  title: string,
  open: boolean,
  ...children: Child[]
): HTMLDetailsElement & { body: HTMLElement } {
  const body = h("div", "section-body", ...children);
  const made = h("details", "section", h("summary", { text: title }), body);
  made.open = open;
  return Object.assign(made, { body });
}

export const hint = (text: string): HTMLElement => h("p", { class: "hint", text });

/** Debounce: call a function after a number of milliseconds without further calls. */
export function debounced<A extends unknown[]>(ms: number, call: (...args: A) => void): (...args: A) => void {
  let timer: ReturnType<typeof setTimeout> | undefined;
  return (...args) => {
    clearTimeout(timer);
    timer = setTimeout(() => call(...args), ms);
  };
}

/** Throttle: call a function at most once per number of milliseconds. */
export function paced(ms: number, call: () => void): () => void {
  let timer: ReturnType<typeof setTimeout> | undefined;
  return () => {
    timer ??= setTimeout(() => {
      timer = undefined;
      call();
    }, ms);
  };
}

/** Download a file. */
export function download(name: string, data: Blob): void {
  const link = h("a", { attrs: { href: URL.createObjectURL(data), download: name } });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60_000);
}

/** File name from a title. */
export function fileName(title: string, ending: string): string {
  const stem = title.toLowerCase().replace(/\.[a-z0-9]{1,5}$/, "").replace(/[^\p{L}\p{N}]+/gu, "-");
  return `${stem.replace(/^-|-$/g, "") || "jousto"}.${ending}`;
}
