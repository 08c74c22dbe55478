// Unpacks bytes that a page holds as text.

/** The bytes of a text in base64. */
export function bytesOfBase64(text) {
  if (Uint8Array.fromBase64) return Uint8Array.fromBase64(text);
  const binary = atob(text);
  const bytes = new Uint8Array(binary.length);
  for (let i = 0; i < bytes.length; i++) bytes[i] = binary.charCodeAt(i);
  return bytes;
}

/** Resolves to the `size` bytes that a zlib stream holds. */
export async function inflate(bytes, size) {
  const inflated = new Uint8Array(size);
  let at = 0;
  const reader = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate")).getReader();
  for (let piece = await reader.read(); !piece.done; piece = await reader.read()) {
    inflated.set(piece.value, at);
    at += piece.value.length;
  }
  if (at !== size) throw new Error(`the points are ${at} bytes, ${size} were expected`);
  return inflated;
}
