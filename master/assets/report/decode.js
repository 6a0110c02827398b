"use strict";
// Decodes the bytes of the picture. encode.rs defines the format.

/** Bytes of base64 text, decompressed (zlib). */
async function unpacked(text) {
  const letters = atob(text);
  const bytes = new Uint8Array(letters.length);
  for (let i = 0; i < letters.length; i++) bytes[i] = letters.charCodeAt(i);
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** Numbers of a column: first the lowest byte of each number. */
class Columns {
  constructor(bytes) {
    this.bytes = bytes;
    this.at = 0;
  }

  plain(count, width) {
    const numbers = new Uint32Array(count);
    for (let b = 0; b < width; b++) {
      for (let i = 0; i < count; i++) numbers[i] |= this.bytes[this.at + i] << (8 * b);
      this.at += count;
    }
    return numbers;
  }

  /** Each number is stored as the difference from the previous one. */
  chain(count) {
    const numbers = this.plain(count, 4);
    let last = 0;
    for (let i = 0; i < count; i++) numbers[i] = last = (last + signed(numbers[i])) >>> 0;
    return numbers;
  }

  /** Differences from the same column at the previous time. */
  since(before) {
    const numbers = new Uint16Array(before.length);
    const change = this.plain(before.length, 2);
    for (let i = 0; i < numbers.length; i++) numbers[i] = before[i] + signed(change[i]);
    return numbers;
  }

  bytesSince(before) {
    const numbers = new Uint8Array(before.length);
    for (let i = 0; i < numbers.length; i++) numbers[i] = before[i] + this.bytes[this.at + i];
    this.at += numbers.length;
    return numbers;
  }
}

/** Zigzag: 0, -1, 1, -2, ... */
function signed(number) {
  return (number >>> 1) ^ -(number & 1);
}

/** Ids of nodes or elements: their lower words, then their upper words. */
function ids(read, count) {
  const [low, high] = [read.chain(count), read.chain(count)];
  return Float64Array.from(low, (word, i) => word + 2 ** 32 * high[i]);
}

/** A scalar that is not finite. */
const NO_VALUE = 65535;

/** The model: constant data and frames. */
function decode(bytes, model) {
  const read = new Columns(bytes);
  const corners = read.chain(4 * model.faces);
  const owners = [read.chain(model.faces), read.chain(model.faces)];
  const elementIds = ids(read, model.elements);
  const nodeIds = ids(read, model.nodes);
  const part = read.plain(model.elements, 2);
  const ofElements = () => new Uint16Array(model.elements);
  const ofNodes = () => new Uint16Array(model.nodes);
  let before = {
    state: new Uint8Array(model.elements),
    worker: ofElements(),
    scalars: model.ranges.map(ofElements),
    nodeScalars: model.node_ranges.map(ofNodes),
    position: [ofNodes(), ofNodes(), ofNodes()],
  };
  const frames = model.frames.map((grid, k) => {
    const frame = {
      grid,
      time: grid.time,
      state: read.bytesSince(before.state),
      worker: read.since(before.worker),
      scalars: before.scalars.map((column) => read.since(column)),
      nodeScalars: before.nodeScalars.map((column) => read.since(column)),
      position: before.position.map((column) => read.since(column)),
    };
    const acting = model.forces[k] ?? 0;
    frame.forces = { nodes: read.chain(acting), components: [0, 1, 2].map(() => new Float32Array(read.chain(acting).buffer)) };
    before = frame;
    return frame;
  });
  if (read.at !== bytes.length) throw new Error(`the picture has ${bytes.length} bytes, but needs ${read.at}`);
  return { ...model, corners, owners, elementIds, nodeIds, part, frames };
}
