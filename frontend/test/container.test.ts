import assert from "node:assert/strict";
import { test } from "node:test";
import { decode, half } from "../src/protocol";
import type { Block } from "../src/protocol";

function container(header: object, payload: ArrayBuffer): ArrayBuffer {
  let text = JSON.stringify(header);
  while ((8 + text.length) % 8) text += " ";
  const out = new Uint8Array(8 + text.length + payload.byteLength);
  out.set(new TextEncoder().encode("JOV1"));
  new DataView(out.buffer).setUint32(4, text.length, true);
  out.set(new TextEncoder().encode(text), 8);
  out.set(new Uint8Array(payload), 8 + text.length);
  return out.buffer;
}

test("arrays of a container stand where its header says", () => {
  const payload = new ArrayBuffer(32);
  new Float64Array(payload).set([1.5, -2, 0.25]);
  new Uint16Array(payload, 24).set([7, 65535]);
  const header = {
    a: { at: 0, shape: [3, 1], type: "f8" },
    deep: [{ b: { at: 24, shape: [2], type: "u2" } }],
    n: 4,
  };
  const read = decode(container(header, payload)) as unknown as { a: Block; deep: { b: Block }[]; n: number };
  assert.deepEqual([...read.a.data], [1.5, -2, 0.25]);
  assert.deepEqual(read.a.shape, [3, 1]);
  assert.deepEqual([...read.deep[0].b.data], [7, 65535]);
  assert.equal(read.n, 4);
});

test("a container that is cut off or of another kind is refused", () => {
  const whole = container({ a: { at: 0, shape: [1], type: "f8" } }, new ArrayBuffer(8));
  assert.throws(() => decode(whole.slice(0, whole.byteLength - 1)), /ends within an array/);
  assert.throws(() => decode(whole.slice(0, 12)), /ends within its header/);
  assert.throws(() => decode(new TextEncoder().encode("GIF89a..").buffer), /not a container/);
});

test("half floats", () => {
  // IEEE 754-2008, binary16: 1, -2, the largest, the smallest normal and subnormal number
  assert.equal(half(0x3c00), 1);
  assert.equal(half(0xc000), -2);
  assert.equal(half(0x7bff), 65504);
  assert.equal(half(0x0400), 2 ** -14);
  assert.equal(half(0x0001), 2 ** -24);
  assert.equal(half(0xfc00), -Infinity);
  assert.ok(Number.isNaN(half(0x7e00)));
});
