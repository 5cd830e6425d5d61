/** What `lamc/view/pack.py` packed: data with typed arrays in it */
async function unpacked(text) {
  const bytes = Uint8Array.from(atob(text.trim()), (letter) => letter.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  const whole = await new Response(stream).arrayBuffer();
  const length = new DataView(whole).getUint32(0, true);
  const first = Math.ceil((4 + length) / 8) * 8;
  const kinds = { Uint8Array, Int16Array, Uint16Array, Uint32Array, Float32Array, Float64Array };
  const revived = (_, value) => {
    const reference = value !== null && typeof value === "object" ? value.$ : undefined;
    return reference === undefined ? value : new kinds[reference[0]](whole, first + reference[1], reference[2]);
  };
  return JSON.parse(new TextDecoder().decode(new Uint8Array(whole, 4, length)), revived);
}

/** Columns of numbers that `recording.py` shortened: differences along time, modulo 2^16, low bytes before high ones */
function lengthened({ columns, low, step, bytes }) {
  const count = bytes.length / 2;
  const rows = columns === 0 ? 0 : count / columns;
  return Array.from({ length: columns }, (_, c) => {
    const values = new Float64Array(rows);
    let level = 0;
    for (let i = 0; i < rows; i++) {
      const place = c * rows + i;
      level = (level + bytes[place] + 256 * bytes[count + place]) & 0xffff;
      values[i] = low[c] + step[c] * level;
    }
    return values;
  });
}
