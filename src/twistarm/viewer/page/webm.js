// A WebM file with one track of VP8 frames (RFC 8794 and RFC 9559), with its duration and places to seek to.

const TRACK = 1;

// `frames`: data, time [ms], and key: whether one stands alone. The first does; each begins a cluster.
export function webm(frames, { width, height, duration }) {
  const length = new DataView(new ArrayBuffer(8));
  length.setFloat64(0, duration);
  const head = element(0x1a45dfa3, element(0x4286, 1), element(0x42f7, 1), element(0x42f2, 4), element(0x42f3, 8), element(0x4282, "webm"), element(0x4287, 2), element(0x4285, 2));
  const info = element(0x1549a966, element(0x2ad7b1, 1e6), element(0x4489, length), element(0x4d80, "twistarm"), element(0x5741, "twistarm"));
  const picture = element(0xe0, element(0xb0, width), element(0xba, height));
  const track = element(0x1654ae6b, element(0xae, element(0xd7, TRACK), element(0x73c5, TRACK), element(0x83, 1), element(0x9c, 0), element(0x86, "V_VP8"), picture));
  const starts = frames.flatMap(({ key }, i) => (key ? [i] : []));
  const clusters = starts.map((from, i) => cluster(frames.slice(from, starts[i + 1])));
  const cues = (at) => element(0x1c53bb6b, starts.map((from, i) => {
    const place = at + size(clusters.slice(0, i).flat());
    return element(0xbb, element(0xb3, frames[from].time), element(0xb7, element(0xf7, TRACK), element(0xf1, place)));
  }));
  const ahead = size([...info, ...track, ...cues(0)]); // numbers of any value take eight bytes
  return new Blob([...head, ...element(0x18538067, info, track, cues(ahead), clusters)], { type: "video/webm" });
}

function cluster(frames) {
  const [{ time: begun }] = frames;
  return element(0x1f43b675, element(0xe7, begun), frames.map(({ data, time, key }) => {
    const header = new DataView(new ArrayBuffer(4));
    header.setUint8(0, 0x80 | TRACK);
    header.setInt16(1, time - begun);
    header.setUint8(3, key ? 0x80 : 0);
    return element(0xa3, header, data);
  }));
}

// The parts of an element: its name, its length, and what it holds: whole numbers, texts, bytes, elements.
function element(id, ...parts) {
  const inside = parts.flat(Infinity).map(packed);
  const name = id.toString(16).match(/../g).map((pair) => parseInt(pair, 16));
  return [new Uint8Array(name), whole(2n ** 56n + BigInt(size(inside))), ...inside];
}

function packed(part) {
  if (typeof part === "string") return new TextEncoder().encode(part);
  return typeof part === "number" ? whole(BigInt(part)) : part;
}

function whole(number) {
  const bytes = new DataView(new ArrayBuffer(8));
  bytes.setBigUint64(0, number);
  return bytes;
}

const size = (parts) => parts.reduce((sum, { byteLength }) => sum + byteLength, 0);
