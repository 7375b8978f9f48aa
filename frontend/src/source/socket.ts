/** Scenes and numbers from the server that serves this page. */

import type { Failure, History, Live, Probe, Rows, Scene, Touches, Window, Worst } from "../protocol";
import { decode } from "../protocol";
import type { Source } from "./source";
import { keep } from "./said";

const LOOK = 2000; // time between checks of the files, ms

interface Waiting {
  resolve: (value: Record<string, unknown>) => void;
  reject: (reason: Error) => void;
}

export class SocketSource implements Source {
  readonly exact = true;
  readonly served = true;
  live = false;
  private count = 0;
  private waiting = new Map<number, Waiting>();
  private listeners = new Set<(live: Live) => void>();

  private constructor(
    private socket: WebSocket,
    private lost: (message: string) => void,
  ) {
    window.setInterval(() => void this.look(), LOOK);
    socket.onmessage = (event) => this.receive(event.data);
    socket.onclose = () => this.closed();
  }

  /** Connect to the server of this page; `lost` receives a sentence when the connection ends. */
  static open(lost: (message: string) => void): Promise<SocketSource> {
    const address = new URL("socket", window.location.href);
    address.protocol = address.protocol === "https:" ? "wss:" : "ws:";
    address.search = window.location.search;
    address.hash = "";
    const socket = new WebSocket(address);
    socket.binaryType = "arraybuffer";
    return new Promise((resolve, reject) => {
      socket.onopen = () => resolve(new SocketSource(socket, lost));
      socket.onerror = () => reject(new Error("The server of this page does not answer: was its command ended?"));
    });
  }

  async scene(run: number): Promise<Scene> {
    const scene = (await this.ask("scene", { run })) as unknown as Scene;
    this.live ||= scene.what === "live";
    return scene;
  }

  async rows(run: number, first: number, count: number, every: number): Promise<Rows> {
    return (await this.ask("rows", { run, first, count, every })) as unknown as Rows;
  }

  async touches(run: number, first: number, count: number): Promise<Touches> {
    return (await this.ask("touches", { run, first, count })) as unknown as Touches;
  }

  async window(run: number, start: number, end: number): Promise<Window> {
    return (await this.ask("window", { run, start, end })) as unknown as Window;
  }

  async probe(run: number, body: number, vertex: number, time: number): Promise<Probe> {
    return (await this.ask("probe", { run, body, vertex, time })) as unknown as Probe;
  }

  async history(run: number, body: number, vertex: number, of: string[], most: number): Promise<History> {
    return (await this.ask("history", { run, body, vertex, of, most })) as unknown as History;
  }

  async sensor(run: number, names: string[], most: number): Promise<History> {
    return (await this.ask("sensor", { run, names, most })) as unknown as History;
  }

  async worst(run: number, measure: string, count: number): Promise<Worst[]> {
    return (await this.ask("worst", { run, measure, count }))["worst"] as Worst[];
  }

  async extent(run: number, measure: string): Promise<[number, number]> {
    const { low, high } = (await this.ask("extent", { run, measure })) as { low: number; high: number };
    return [low, high];
  }

  async order(order: Record<string, unknown>): Promise<void> {
    await this.send(order);
  }

  onLive(call: (live: Live) => void): () => void {
    this.listeners.add(call);
    return () => this.listeners.delete(call);
  }

  /** Check that the server still shows the same files. */
  private async look(): Promise<void> {
    if (this.live || this.socket.readyState !== WebSocket.OPEN || this.waiting.size) return;
    try {
      await this.ask("still", {});
    } catch (error) {
      if (this.socket.readyState === WebSocket.OPEN) this.lost((error as Error).message);
    }
  }

  private ask(ask: string, parameters: Record<string, unknown>): Promise<Record<string, unknown>> {
    return this.send({ ask, ...parameters });
  }

  private send(message: Record<string, unknown>): Promise<Record<string, unknown>> {
    if (this.socket.readyState !== WebSocket.OPEN) {
      return Promise.reject(new Error("The server of this page has ended."));
    }
    const id = ++this.count;
    this.socket.send(JSON.stringify({ id, ...message }));
    return new Promise((resolve, reject) => this.waiting.set(id, { resolve, reject }));
  }

  private receive(data: ArrayBuffer | string): void {
    const message = typeof data === "string" ? (JSON.parse(data) as Record<string, unknown>) : decode(data);
    if (message["kind"] === "live") {
      for (const call of this.listeners) call(message as unknown as Live);
      return;
    }
    const id = message["id"] as number;
    const waiting = this.waiting.get(id);
    if (!waiting) return;
    this.waiting.delete(id);
    if (message["renewed"]) {
      // the content has changed: reload the page
      const said = (message as unknown as Failure).message.replace(/^page: /, "");
      keep(`${said}: the page shows what is in it now.`);
      window.location.reload();
      return;
    }
    if (message["kind"] === "error") waiting.reject(new Error((message as unknown as Failure).message));
    else waiting.resolve(message);
  }

  private closed(): void {
    const message = "The server of this page has ended; what is loaded can still be seen.";
    for (const { reject } of this.waiting.values()) reject(new Error(message));
    this.waiting.clear();
    this.lost(message);
  }
}
