import assert from "node:assert/strict";
import { test } from "node:test";
import { instants } from "../src/export/video";
import { webm } from "../src/export/webm";
import { stick } from "../src/panels/pad";

test("pictures of a video are even in time and reach the end", () => {
  assert.deepEqual(instants(0, 1, 1, 4), [0, 0.25, 0.5, 0.75, 1]);
  assert.equal(instants(0, 12, 2, 30).length, 181);
  assert.equal(instants(3, 3, 1, 30).length, 1);
});

/** Elements of a piece of EBML: identifier in hex, content, and where it begins. */
function elements(data: Uint8Array): { id: string; content: Uint8Array; at: number }[] {
  const found = [];
  for (let at = 0; at < data.length; ) {
    const from = at;
    const width = Math.clz32(data[at]) - 23;
    const id = Buffer.from(data.subarray(at, at + width)).toString("hex");
    at += width;
    const length = Math.clz32(data[at]) - 23;
    let size = data[at] & ((1 << (8 - length)) - 1);
    for (let i = 1; i < length; i++) size = size * 256 + data[at + i];
    at += length;
    found.push({ id, content: data.subarray(at, at + size), at: from });
    at += size;
  }
  return found;
}

test("a WebM file has its pictures, and an index that points to its clusters", () => {
  const pictures = [0, 1, 2, 3].map((i) => ({ data: Uint8Array.of(i, i), time: 40 * i, key: i % 2 === 0 }));
  const file = Buffer.concat(webm("V_VP9", 640, 360, 40, pictures));
  const [head, segment] = elements(file);
  assert.equal(head.id, "1a45dfa3");
  assert.equal(segment.id, "18538067");
  const inside = elements(segment.content);
  assert.deepEqual(inside.map(({ id }) => id), ["1549a966", "1654ae6b", "1f43b675", "1f43b675", "1c53bb6b"]);
  const duration = elements(inside[0].content).find(({ id }) => id === "4489")!;
  assert.equal(Buffer.from(duration.content).readDoubleBE(), 160);
  const blocks = inside.slice(2, 4).flatMap(({ content }) => elements(content).filter(({ id }) => id === "a3"));
  assert.deepEqual(blocks.map(({ content }) => [...content]), [
    [0x81, 0, 0, 0x80, 0, 0],
    [0x81, 0, 40, 0, 1, 1],
    [0x81, 0, 0, 0x80, 2, 2],
    [0x81, 0, 40, 0, 3, 3],
  ]);
  const places = elements(inside[4].content).map(({ content }) => {
    const positions = elements(content).find(({ id }) => id === "b7")!;
    const place = elements(positions.content).find(({ id }) => id === "f1")!;
    return Number(Buffer.from(place.content).readBigUInt64BE());
  });
  const times = elements(inside[4].content).map(({ content }) => [...elements(content).find(({ id }) => id === "b3")!.content]);
  assert.deepEqual(times, [[0], [80]]);
  assert.deepEqual(places, [inside[2].at, inside[3].at]);
});

test("a stick that is let go gives the value at the start, at its stop the end of the range", () => {
  const input = { name: "valve", unit: "1", low: -2, high: 1, value: 0.5 };
  assert.equal(stick(input, 0.05, 0.5), 0.5);
  assert.equal(stick(input, 1, 0.5), 1);
  assert.equal(stick(input, -1, 0.5), -2);
});
