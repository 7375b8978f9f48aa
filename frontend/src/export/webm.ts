/** WebM file (Matroska, RFC 9559) from encoded frames, with an index for seeking. */

export interface Picture {
  data: Uint8Array;
  /** ms */
  time: number;
  key: boolean;
}

type Tree = [id: number[], content: Uint8Array | Tree[]];

const text = (value: string): Uint8Array => new TextEncoder().encode(value);

function unsigned(value: number): Uint8Array {
  const bytes: number[] = [];
  for (let rest = value; rest > 0 || !bytes.length; rest = Math.floor(rest / 256)) bytes.unshift(rest % 256);
  return Uint8Array.from(bytes);
}

function float(value: number): Uint8Array {
  const bytes = new Uint8Array(8);
  new DataView(bytes.buffer).setFloat64(0, value);
  return bytes;
}

/*Length in 8 bytes, for any size with a constant width. */
function size(value: number): Uint8Array {
  const bytes = new Uint8Array(8);
  const view = new DataView(bytes.buffer);
  view.setUint32(0, Math.floor(value / 2 ** 32));
  view.setUint32(4, value % 2 ** 32);
  bytes[0] = 0x01;
  return bytes;
}

function write([id, content]: Tree): Uint8Array[] {
  const inner = content instanceof Uint8Array ? [content] : content.flatMap(write);
  const length = inner.reduce((sum, part) => sum + part.length, 0);
  return [Uint8Array.from(id), size(length), ...inner];
}

const bytes = (trees: Tree[]): number => trees.flatMap(write).reduce((sum, part) => sum + part.length, 0);

/** Make a WebM file of frames; `codec` is `V_VP9` or `V_VP8`, `step` the frame time, ms. */
export function webm(
  codec: "V_VP8" | "V_VP9",
  width: number,
  height: number,
  step: number,
  pictures: readonly Picture[],
): Uint8Array[] {
  const head: Tree = [
    [0x1a, 0x45, 0xdf, 0xa3],
    [
      [[0x42, 0x86], unsigned(1)],
      [[0x42, 0xf7], unsigned(1)],
      [[0x42, 0xf2], unsigned(4)],
      [[0x42, 0xf3], unsigned(8)],
      [[0x42, 0x82], text("webm")],
      [[0x42, 0x87], unsigned(4)],
      [[0x42, 0x85], unsigned(2)],
    ],
  ];
  const last = pictures[pictures.length - 1];
  const front: Tree[] = [
    [
      [0x15, 0x49, 0xa9, 0x66],
      [
        [[0x2a, 0xd7, 0xb1], unsigned(1_000_000)],
        [[0x44, 0x89], float((last?.time ?? 0) + step)],
        [[0x4d, 0x80], text("jousto")],
        [[0x57, 0x41], text("jousto")],
      ],
    ],
    [
      [0x16, 0x54, 0xae, 0x6b],
      [
        [
          [0xae],
          [
            [[0xd7], unsigned(1)],
            [[0x73, 0xc5], unsigned(1)],
            [[0x9c], unsigned(0)],
            [[0x86], text(codec)],
            [[0x83], unsigned(1)],
            [[0x23, 0xe3, 0x83], unsigned(Math.round(step * 1e6))],
            [[0xe0], [[[0xb0], unsigned(width)], [[0xba], unsigned(height)]]],
          ],
        ],
      ],
    ],
  ];
  // a cluster begins at each key frame; times within it have 16 bits
  const clusters: Tree[] = [];
  const starts: number[] = [];
  let blocks: Tree[] = [];
  for (const picture of pictures) {
    const start = starts[starts.length - 1];
    if (picture.key || start === undefined || picture.time - start > 30_000) {
      starts.push(Math.round(picture.time));
      blocks = [[[0xe7], unsigned(Math.round(picture.time))]];
      clusters.push([[0x1f, 0x43, 0xb6, 0x75], blocks]);
    }
    const block = new Uint8Array(4 + picture.data.length);
    const relative = Math.round(picture.time) - starts[starts.length - 1];
    block.set([0x81, relative >> 8, relative & 255, picture.key ? 0x80 : 0]);
    block.set(picture.data, 4);
    blocks.push([[0xa3], block]);
  }
  // positions in the index have 8 bytes, so that its size is known in advance
  let at = bytes(front);
  const cues: Tree[] = clusters.map((cluster, k) => {
    const place = size(at);
    place[0] = 0;
    at += bytes([cluster]);
    return [
      [0xbb],
      [[[0xb3], unsigned(starts[k])], [[0xb7], [[[0xf7], unsigned(1)], [[0xf1], place]]]],
    ];
  });
  return write(head).concat(write([[0x18, 0x53, 0x80, 0x67], [...front, ...clusters, [[0x1c, 0x53, 0xbb, 0x6b], cues]]]));
}
