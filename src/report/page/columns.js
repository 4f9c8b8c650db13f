// Long columns and texts of a page. Columns are packed: differences of bit patterns, bytes ordered by significance, deflated, in base 64.
const columns = new Map();
function inflated(id) {
  const text = atob(document.getElementById(id).textContent);
  const packed = new Uint8Array(text.length);
  for (let i = 0; i < text.length; i++) packed[i] = text.charCodeAt(i);
  return new Response(new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate-raw")));
}
const textOf = async (value) => (typeof value === "string" ? value : inflated("text" + value.text).text());
async function column({ column: id, single, length }) {
  if (!columns.has(id)) {
    const shuffled = new Uint8Array(await inflated("column" + id).arrayBuffer());
    const size = single ? 4 : 8;
    const bytes = new Uint8Array(length * size);
    for (let k = 0; k < size; k++) for (let i = 0; i < length; i++) bytes[i * size + k] = shuffled[k * length + i];
    // Sums of the differences, of doubles in two halves with a carry.
    const words = new Uint32Array(bytes.buffer), step = size / 4;
    for (let i = step; i < words.length; i += step) {
      const low = words[i] + words[i - step];
      words[i] = low;
      if (step === 2) words[i + 1] += words[i - 1] + (low > 0xffffffff ? 1 : 0);
    }
    columns.set(id, single ? new Float32Array(bytes.buffer) : new Float64Array(bytes.buffer));
  }
  return columns.get(id);
}
const isPacked = (value) => value !== null && typeof value === "object" && ("grid" in value || "column" in value);
async function list(value) {
  if (Array.isArray(value)) return value.map((v) => (v === null ? NaN : v));
  if (value.grid) {
    const [first, last, count] = value.grid;
    const even = new Float64Array(count);
    for (let i = 0; i < count; i++) even[i] = first + ((last - first) * i) / (count - 1);
    return even;
  }
  return column(value);
}

// The data of a view, with its long lists.
async function unpacked(value) {
  if (isPacked(value)) return list(value);
  if (Array.isArray(value)) return Promise.all(value.map(unpacked));
  if (value === null || typeof value !== "object") return value;
  const entries = Object.entries(value).map(async ([key, part]) => [key, await unpacked(part)]);
  return Object.fromEntries(await Promise.all(entries));
}
