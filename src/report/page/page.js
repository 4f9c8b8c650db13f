// Figures, keys, tables and sections of a page; light and dark, print.

// Files.
function download(name, text) {
  const link = element("a");
  link.href = URL.createObjectURL(new Blob([text], { type: "text/csv" }));
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}
const cell = (text) => (/[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text);
G.csv = (plot) => {
  if (plot.map) {
    const { from, to, low, step, rows: down, levels, label } = plot.map;
    const rows = [[plot.x.label, plot.y.label, label].map(cell).join(",")];
    levels.forEach((level, n) => { const i = Math.floor(n / down); rows.push([0.5 * (from[i] + to[i]), low + ((n % down) + 0.5) * step, level].join(",")); });
    return rows.join("\n") + "\n";
  }
  const rows = [["curve", plot.x.label, plot.y.label].map(cell).join(",")];
  for (const e of plot.events) e.x.forEach((x, i) => rows.push([cell(`${e.kind} of ${e.sources[e.source[i]]}`), scaled(plot.x, x), ""].join(",")));
  for (const c of plot.curves) for (let i = 0; i < c.x.length; i++) rows.push([cell(c.name), scaled(plot.x, c.x[i]), Number.isFinite(c.y[i]) ? scaled(plot.y, c.y[i]) : ""].join(","));
  return rows.join("\n") + "\n";
};
const scaled = (axis, v) => (axis.factor === 1 ? v : Number((v * axis.factor).toPrecision(15)));
function tableOf(csv) {
  const MOST = 400;
  const lines = csv.trimEnd().split("\n");
  const split = (line) => [...line.matchAll(/("(?:[^"]|"")*"|[^,]*)(?:,|$)/g)].slice(0, -1).map((m) => m[1].replace(/^"|"$/g, "").replaceAll('""', '"'));
  const table = element("table");
  lines.slice(0, MOST + 1).forEach((line, k) => {
    const row = element("tr");
    for (const text of split(line + (line.endsWith(",") ? "," : ""))) row.append(element(k === 0 ? "th" : "td", /[.e]/.test(text) && Number.isFinite(Number(text)) ? number(Number(text)) : text));
    table.append(row);
  });
  const box = element("div", undefined, "table");
  box.append(table);
  if (lines.length > MOST + 1) box.append(element("p", `${lines.length - 1 - MOST} more rows in the CSV file`, "note"));
  return box;
}

// The key of a figure: each name once.
const MARKS = {
  line: (c) => `<path d="M0 6h22" stroke-width="${Math.max(c.size, 1.6)}" stroke-dasharray="${DASHES[c.dash].join(" ")}"/>`,
  event: () => `<path d="M11 1v10"/>`,
  discs: () => `<circle cx="11" cy="6" r="3" fill="currentColor"/>`,
  stems: () => `<circle cx="11" cy="6" r="3" fill="currentColor"/>`,
  rings: () => `<circle cx="11" cy="6" r="3.5"/>`,
  crosses: () => `<path d="M7 2l8 8M7 10l8-8" stroke-width="1.6"/>`,
};
function keyOf(plots, events) {
  const key = element("div", undefined, "key");
  const known = new Set();
  const marks = events.map((e) => ({ ...e, mark: "event" }));
  for (const curve of [...plots.flatMap((p) => (p.at_end ? [] : p.curves)), ...marks]) {
    if (!curve.name || known.has(curve.name)) continue;
    known.add(curve.name);
    const entry = element("span");
    const sign = element("span");
    sign.style.cssText = `color: var(--series-${curve.ink}); margin: 0; opacity: ${curve.pale ? 0.5 : 1}`;
    // Marks are constant texts of this script.
    sign.innerHTML = `<svg width="22" height="12" fill="none" stroke="currentColor">${MARKS[curve.mark](curve)}</svg>`;
    entry.append(sign, curve.name);
    key.append(entry);
  }
  return key;
}

async function unpack(plot) {
  for (const curve of plot.curves) {
    for (const part of ["x", "y", "low", "high", "radii"]) curve[part] = await list(curve[part]);
    if (curve.along) curve.along.values = await list(curve.along.values);
  }
  if (plot.map) for (const part of ["from", "to", "levels"]) plot.map[part] = await list(plot.map[part]);
}
// A colour of a drawing in those of the page, where it is an ink, blue, orange or black, mixed with white paper; colours of maps stay.
function themed(hex) {
  const seen = [1, 3, 5].map((k) => parseInt(hex.slice(k, k + 2), 16));
  for (const [series, ink] of [[0, [0, 90, 160]], [1, [208, 106, 0]], [2, [26, 26, 26]]]) {
    const k = ink.indexOf(Math.min(...ink)), share = (255 - seen[k]) / (255 - ink[k]);
    if (share <= 1 && ink.every((v, i) => Math.abs(255 - share * (255 - v) - seen[i]) < 3)) return `color-mix(in srgb, var(--series-${series}) ${Math.round(100 * share)}%, var(--paper))`;
  }
  return hex;
}
async function figure(figure, host, name) {
  if (figure.svg !== undefined) {
    const box = element("div", undefined, "drawing");
    const text = (await textOf(figure.svg)).replace(/#[0-9A-F]{6}(?=")/g, themed);
    const parsed = new DOMParser().parseFromString(text, "image/svg+xml").documentElement;
    if (!parsed.hasAttribute("viewBox")) parsed.setAttribute("viewBox", `0 0 ${parsed.getAttribute("width")} ${parsed.getAttribute("height")}`);
    box.append(document.importNode(parsed, true));
    host.append(box);
    return;
  }
  const heading = figure.title === data.title ? figure.name : figure.title;
  if (heading) host.append(element("h3", heading));
  if (figure.note) host.append(element("p", figure.note, "note"));
  for (const e of figure.events) for (const part of ["x", "source"]) e[part] = await list(e[part]);
  for (const plot of figure.plots) { plot.events = figure.events; await unpack(plot); }
  host.append(keyOf(figure.plots, figure.events));
  figure.plots.forEach((plot, k) => {
    if (plot.heading) host.append(element("p", plot.heading, "note"));
    const box = element("div", undefined, "plot");
    host.append(box);
    const numbered = !figure.linked || k + 1 === figure.plots.length;
    makePlot(plot, box, figure.linked ? name : null, `${name}.${k + 1}`, numbered, figure.plots.some((p) => p.map));
  });
  if (figure.linked) join(G.plots.filter((p) => p.group === name));
}
// Characters of a last cell that is wrapped.
const SENTENCE = 50;
async function section(part, k, main) {
  const host = element("section");
  host.id = "part" + (k + 1);
  main.append(host);
  if (data.sections.length > 1) host.append(element("h2", `${k + 1} ${part.heading}`));
  if (part.warnings.length) {
    const warnings = element("ul", undefined, "warnings");
    for (const w of part.warnings) {
      const item = element("li");
      item.append(element("b", w.code), " " + w.message + (w.hint ? "; " + w.hint : ""));
      warnings.append(item);
    }
    host.append(warnings);
  }
  // Long sentences are wrapped, those at the end of a row in their column; tables are not.
  const text = element("pre");
  const isTable = (line) => /\S {2}/.test(line);
  const columnOf = (line) => { const at = line.lastIndexOf("  ") + 2; return line.length - at > SENTENCE ? at : 0; };
  let widest = 80;
  for (const line of part.text.trimEnd().split("\n")) {
    const from = isTable(line) ? columnOf(line) : 2;
    const row = element("div", line || " ");
    if (from) row.style.cssText = `white-space:pre-wrap;padding-left:${from}ch;text-indent:-${from}ch;max-width:${from + 128}ch`;
    if (isTable(line)) widest = Math.max(widest, from ? from + SENTENCE : line.length);
    text.append(row);
  }
  // Characters of its widest row, by which print chooses the size.
  text.style.setProperty("--wide", widest);
  host.append(text);
  for (const view of part.views) {
    const box = element("div");
    host.append(element("h3", view.title), box);
    G.kinds[view.kind](await unpacked(view.data), box);
  }
  for (let f = 0; f < part.figures.length; f++) await figure(part.figures[f], host, `p${k + 1}f${f + 1}`);
  const details = (title, content, more) => {
    const box = element("details");
    box.append(element("summary", title), ...(more ? [more] : []), content);
    host.append(box);
  };
  const csv = await textOf(part.csv);
  if (csv.trim()) details("table", tableOf(csv), button("save as CSV", () => download(`part${k + 1}.csv`, csv)));
  if (part.notes.trim()) details("what ran and what was left out", element("pre", part.notes.trim()));
}

// Light and dark.
function theme(dark) {
  root.classList.toggle("dark", dark);
  for (const plot of G.plots) plot.u.redraw(false, true);
  G.redraws.forEach((redraw) => redraw());
}
addEventListener("resize", () => G.redraws.forEach((redraw) => redraw()));
document.getElementById("theme").addEventListener("click", () => theme(!root.classList.contains("dark")));
addEventListener("keydown", (event) => { if (event.key === "t" && !event.ctrlKey && !event.metaKey) theme(!root.classList.contains("dark")); });
root.classList.toggle("dark", matchMedia("(prefers-color-scheme: dark)").matches);
let before = false;
addEventListener("beforeprint", () => { before = root.classList.contains("dark"); theme(false); });
addEventListener("afterprint", () => theme(before));

// For views: the script of a kind names its drawing, which takes the data and an element.
Object.assign(G, { element, button, colour, number, search, shade, makePlot, tip: showTip, kind: (name, draw) => (G.kinds[name] = draw) });
G.start = async () => {
  document.querySelector("h1").textContent = data.title;
  document.querySelector(".command").textContent = data.command;
  document.querySelector("footer").textContent = `geardyn ${data.version}. Drag: zoom; arrow keys, + and −: move and zoom; 0 or double click: all; t: light and dark.`;
  const main = document.querySelector("main");
  if (data.sections.length > 1) data.sections.forEach((part, k) => {
    const link = element("a", `${k + 1} ${part.heading}`);
    link.href = "#part" + (k + 1);
    document.querySelector("nav").append(link);
  });
  for (let k = 0; k < data.sections.length; k++) await section(data.sections[k], k, main);
  readAddress();
  ready = true;
  // Milliseconds from the call of the page.
  root.dataset.ready = Math.ceil(performance.now());
};
