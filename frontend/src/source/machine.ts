/** The engine with one machine, as WebAssembly: numbers in SI, arrays as copies. */

import type { Block } from "../protocol";

/** Exports of the module; see engine/export/page.c. Functions return 0 on success. */
interface Exports extends WebAssembly.Exports {
  memory: WebAssembly.Memory;
  _initialize?: () => void;
  start(): number;
  reset(): number;
  advance(steps: number): number;
  set_input(k: number, value: number): number;
  set_parameter(k: number, value: number): number;
  now(): number;
  error_index(): number;
  positions(): number;
  velocities(): number;
  outputs(): number;
}

export const STOPPED = 1;

export class Machine {
  private constructor(
    private module: Exports,
    readonly nq: number,
    readonly nout: number,
  ) {}

  static async open(code: Block<Uint8Array>, nq: number, nout: number): Promise<Machine> {
    // copy: the container may move when the module grows its memory
    const { instance } = await WebAssembly.instantiate(Uint8Array.from(code.data), {});
    const module = instance.exports as Exports;
    module._initialize?.();
    if (module.start()) throw new Error("The machine of this page does not start.");
    return new Machine(module, nq, nout);
  }

  /** Simulated time, s. */
  get time(): number {
    return this.module.now();
  }

  /** Advance by some steps; returns 0, STOPPED at a terminal event, or a larger number on failure. */
  advance(steps: number): number {
    return this.module.advance(steps);
  }

  /** Index of the event that stopped the run. */
  get stopper(): number {
    return this.module.error_index();
  }

  reset(): void {
    this.module.reset();
  }

  input(k: number, value: number): boolean {
    return this.module.set_input(k, value) === 0;
  }

  parameter(k: number, value: number): boolean {
    return this.module.set_parameter(k, value) === 0;
  }

  /** Positions of all bodies in the engine's layout. */
  positions(): Float64Array {
    return this.numbers(this.module.positions(), this.nq);
  }

  /** Values of all sensors; null if they cannot be computed. */
  outputs(): Float64Array | null {
    const at = this.module.outputs();
    return at ? this.numbers(at, this.nout) : null;
  }

  private numbers(at: number, count: number): Float64Array {
    return new Float64Array(this.module.memory.buffer, at, count).slice();
  }
}
