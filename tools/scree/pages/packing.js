"use strict";

/** The bytes of gzipped base64. */
async function unzipped(text) {
  const letters = atob(text), packed = new Uint8Array(letters.length);
  for (let i = 0; i < packed.length; i++) packed[i] = letters.charCodeAt(i);
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** The whole numbers of an array, as packing.py says. */
function unfolded(bytes, entry) {
  const length = entry.shape.reduce((a, b) => a * b, 1), row = entry.shape.at(-1), found = new Int32Array(length);
  for (let plane = 0; plane < entry.bytes; plane++) {
    const at = entry.at + plane * length, shift = 8 * plane;
    for (let i = 0; i < length; i++) found[i] |= bytes[at + i] << shift;
  }
  for (let i = 0; i < length; i++) {
    const change = (found[i] >>> 1) ^ -(found[i] & 1);
    found[i] = i % row ? found[i - 1] + change : change;
  }
  return found;
}

/** An array whose last axis is time, with all of a frame together. */
function byFrame(values, frames, Kind) {
  const items = values.length / frames, found = new Kind(values.length);
  for (let i = 0; i < items; i++) for (let k = 0; k < frames; k++) found[k * items + i] = values[i * frames + k];
  return found;
}
