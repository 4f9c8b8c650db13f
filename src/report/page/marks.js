// Drawing within the axes of a plot: curves, maps, guides, events, names.

// Viridis of matplotlib (van der Walt & Smith 2015) at nine even steps.
const SCALE = [[68, 1, 84], [71, 45, 123], [59, 82, 139], [44, 114, 142], [33, 145, 140], [40, 174, 128], [94, 201, 98], [173, 220, 48], [253, 231, 37]];
function shade(share) {
  const at = Math.min(Math.max(share, 0), 1) * (SCALE.length - 1);
  const k = Math.min(Math.floor(at), SCALE.length - 2);
  return SCALE[k].map((v, i) => Math.round(v + (at - k) * (SCALE[k + 1][i] - v)));
}
function mapImage(map) {
  const [across, down] = [map.from.length, map.rows];
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [across, down];
  const image = canvas.getContext("2d").createImageData(across, down);
  for (let i = 0; i < across; i++) for (let k = 0; k < down; k++) {
    const level = map.levels[i * down + k];
    const at = 4 * ((down - 1 - k) * across + i);
    image.data.set([...shade((level - map.scale[0]) / (map.scale[1] - map.scale[0])), 255], at);
  }
  canvas.getContext("2d").putImageData(image, 0, 0);
  return canvas;
}

// One plot.
const DASHES = { solid: [], dashed: [7, 5], dotted: [2, 4] };
function drawCurve(plot, ctx, curve) {
  const { x, y } = curve;
  const [px, py] = [plot.toX, plot.toY];
  ctx.strokeStyle = ctx.fillStyle = plot.ink(curve);
  ctx.globalAlpha = curve.pale ? 0.45 : 1;
  ctx.lineWidth = Math.max(curve.mark === "line" ? curve.size * 1.25 : 1.3, 0.8) * devicePixelRatio;
  ctx.setLineDash(DASHES[curve.dash].map((d) => d * devicePixelRatio));
  const scale = devicePixelRatio * 1.2;
  for (let i = 0; i < curve.low.length; i++) {
    ctx.globalAlpha = 0.45;
    ctx.beginPath();
    ctx.moveTo(px(x[i]), py(curve.low[i]));
    ctx.lineTo(px(x[i]), py(curve.high[i]));
    ctx.stroke();
    ctx.globalAlpha = curve.pale ? 0.45 : 1;
  }
  if (curve.mark === "line") return drawLine(plot, ctx, curve);
  const foot = plot.u.bbox.top + plot.u.bbox.height;
  for (let i = 0; i < x.length; i++) {
    const [cx, cy] = [px(x[i]), py(y[i])];
    if (!Number.isFinite(cx + cy)) continue;
    const r = (curve.radii[i] ?? curve.size) * scale;
    ctx.beginPath();
    if (curve.mark === "crosses") {
      ctx.moveTo(cx - r, cy - r); ctx.lineTo(cx + r, cy + r); ctx.moveTo(cx - r, cy + r); ctx.lineTo(cx + r, cy - r);
      ctx.stroke();
      continue;
    }
    if (curve.mark === "stems") { ctx.moveTo(cx, foot); ctx.lineTo(cx, cy); ctx.stroke(); ctx.beginPath(); }
    ctx.arc(cx, cy, r, 0, 2 * Math.PI);
    curve.mark === "rings" ? ctx.stroke() : ctx.fill();
  }
}
// A line. Of points in rising order, blocks that share a pixel column are drawn by their extremes.
function drawLine(plot, ctx, curve) {
  const { x, y, rising } = curve;
  const [px, py] = [plot.toX, plot.toY];
  let [i, to] = [0, x.length];
  if (rising) {
    const [low, high] = plot.shown.x;
    i = Math.max(search(x, low) - 1, 0);
    to = Math.min(search(x, high) + 2, x.length);
    curve.levels ??= extremes(y);
  }
  ctx.beginPath();
  let open = false;
  const point = (cx, cy) => { if (!Number.isFinite(cx + cy)) return void (open = false); open ? ctx.lineTo(cx, cy) : ctx.moveTo(cx, cy); open = true; };
  while (i < to) {
    const cx = px(x[i]);
    let [size, block] = [1, null];
    if (rising) for (const level of curve.levels) {
      if (i % (4 * size) || i + 4 * size > to || px(x[i + 4 * size - 1]) - cx >= 1) break;
      [size, block] = [4 * size, level];
    }
    if (block) { point(cx, py(block[0][i / size])); point(cx, py(block[1][i / size])); } else point(cx, py(y[i]));
    i += size;
  }
  ctx.stroke();
}
// Least and greatest values of blocks of 4, 16, 64 … points, not finite where one of them is not.
function extremes(y) {
  const levels = [];
  for (let [low, high] = [y, y]; low.length >= 1024; levels.push([low, high])) {
    const ends = [0, 1].map(() => new Float64Array(low.length >> 2));
    for (let k = 0, i = 0; k < ends[0].length; k++, i += 4) {
      ends[0][k] = Math.min(low[i], low[i + 1], low[i + 2], low[i + 3]);
      ends[1][k] = Math.max(high[i], high[i + 1], high[i + 2], high[i + 3]);
    }
    [low, high] = ends;
  }
  return levels;
}
const search = (values, x) => {
  let [low, high] = [0, values.length];
  while (low < high) { const middle = (low + high) >> 1; values[middle] < x ? (low = middle + 1) : (high = middle); }
  return low;
};
const isRising = (x) => { for (let i = 1; i < x.length; i++) if (!(x[i] >= x[i - 1])) return false; return true; };

function drawMap(plot, ctx) {
  const { map } = plot;
  plot.image ??= mapImage(map);
  const [top, foot] = [plot.toY(map.low + map.rows * map.step), plot.toY(map.low)];
  ctx.imageSmoothingEnabled = false;
  for (let i = 0; i < map.from.length; i++) {
    const [left, right] = [plot.toX(map.from[i]), plot.toX(map.to[i])];
    ctx.drawImage(plot.image, i, 0, 1, map.rows, Math.floor(left), top, Math.ceil(right) - Math.floor(left), foot - top);
  }
}
// The scale of colours, right of the map.
function drawScale(plot, ctx) {
  const { left, top, width, height } = plot.u.bbox;
  const { scale, label: text } = plot.map;
  const dpr = devicePixelRatio;
  const [from, across, steps] = [left + width + 14 * dpr, 14 * dpr, 60];
  for (let k = 0; k < steps; k++) {
    ctx.fillStyle = `rgb(${shade((k + 0.5) / steps).join(",")})`;
    ctx.fillRect(from, top + height * (1 - (k + 1) / steps), across, Math.ceil(height / steps) + 1);
  }
  ctx.font = `${11 * dpr}px system-ui, sans-serif`;
  ctx.textAlign = "left";
  ctx.textBaseline = "middle";
  ctx.fillStyle = colour("--text");
  const span = scale[1] - scale[0], rough = span / 6, decade = 10 ** Math.floor(Math.log10(rough));
  const step = decade * [1, 2, 5, 10].find((n) => n * decade >= rough);
  for (let n = Math.ceil(scale[0] / step); n * step <= scale[1]; n++) ctx.fillText(number(n * step), from + across + 4 * dpr, top + height * (1 - (n * step - scale[0]) / span));
  ctx.save();
  ctx.translate(from + across + 46 * dpr, top + height / 2);
  ctx.rotate(-Math.PI / 2);
  ctx.textAlign = "center";
  ctx.fillText(text, 0, 0);
  ctx.restore();
}
function drawBehind(plot, ctx) {
  const { left, top, width, height } = plot.u.bbox;
  for (const band of plot.bands) {
    ctx.fillStyle = colour("--grid");
    ctx.fillRect(plot.toX(band.from), top, plot.toX(band.to) - plot.toX(band.from), height);
    label(plot, ctx, band.name, 0.5 * (plot.toX(band.from) + plot.toX(band.to)), top + height - 8 * devicePixelRatio, "center", "--quiet");
  }
}
// Lines at values of one axis, above a map and below curves.
function drawGuides(plot, ctx) {
  const { left, top, width, height } = plot.u.bbox;
  for (const guide of plot.guides) {
    ctx.lineWidth = devicePixelRatio;
    ctx.strokeStyle = colour(plot.map ? "--series-6" : "--quiet");
    ctx.setLineDash(guide.dotted ? [2 * devicePixelRatio, 3 * devicePixelRatio] : []);
    ctx.beginPath();
    const at = guide.vertical ? plot.toX(guide.at) : plot.toY(guide.at);
    guide.vertical ? (ctx.moveTo(at, top), ctx.lineTo(at, top + height)) : (ctx.moveTo(left, at), ctx.lineTo(left + width, at));
    ctx.stroke();
    if (guide.name && !guide.vertical) label(plot, ctx, guide.name, left + 6 * devicePixelRatio, at - 8 * devicePixelRatio, "left", "--text");
  }
  ctx.setLineDash([]);
}
// Ticks of events at the foot, one row a kind.
const EVENT_ROW = 8;
function drawEvents(plot, ctx) {
  const row = EVENT_ROW * devicePixelRatio;
  plot.events.forEach(({ ink, x }, k) => {
    const foot = plot.u.bbox.top + plot.u.bbox.height - k * row;
    ctx.strokeStyle = colour("--series-" + ink);
    ctx.lineWidth = devicePixelRatio;
    ctx.setLineDash([]);
    ctx.beginPath();
    for (let i = search(x, plot.shown.x[0]); i < x.length && x[i] <= plot.shown.x[1]; i++) { const at = plot.toX(x[i]); ctx.moveTo(at, foot); ctx.lineTo(at, foot - row + devicePixelRatio); }
    ctx.stroke();
  });
}
// The event under the pointer: its text.
function eventAt(plot, mx, my) {
  const kind = plot.events[Math.floor((plot.u.over.clientHeight - my) / EVENT_ROW)];
  if (!kind) return "";
  const { x } = kind, at = search(x, plot.u.posToVal(mx, "x"));
  const away = (i) => Math.abs(plot.u.valToPos(x[i], "x") - mx);
  const near = at > 0 && !(away(at - 1) > away(at)) ? at - 1 : at;
  return away(near) < 6 ? `${kind.kind} of ${kind.sources[kind.source[near]]}\n${plot.x.label}: ${axisText(plot.x)(x[near])}` : "";
}
function label(plot, ctx, text, x, y, align, ink) {
  ctx.font = `${11 * devicePixelRatio}px system-ui, sans-serif`;
  ctx.textAlign = align;
  ctx.textBaseline = "middle";
  ctx.setLineDash([]);
  const width = ctx.measureText(text).width;
  const { left, width: across } = plot.u.bbox;
  // In the middle of a place: inside the plot on both sides.
  const at = align === "center" ? Math.min(Math.max(x, left + width / 2), left + across - width / 2) : x;
  ctx.lineWidth = 3 * devicePixelRatio;
  // Maps are dark in both themes.
  ctx.strokeStyle = plot.map ? "#1a1a1a" : colour("--paper");
  ctx.globalAlpha = 0.8;
  ctx.strokeText(text, at, y);
  ctx.globalAlpha = 1;
  ctx.fillStyle = plot.map ? "#fff" : colour(ink);
  ctx.fillText(text, at, y);
}
// Names of points, the most important first, where they cover no other name; then names at the ends of curves.
function drawNames(plot, ctx) {
  const taken = [];
  const place = (text, x, y, align, ink) => {
    ctx.font = `${11 * devicePixelRatio}px system-ui, sans-serif`;
    const width = ctx.measureText(text).width;
    const { left, top, width: across, height } = plot.u.bbox;
    const right = left + across + (align === "center" ? 0 : (plot.margin - 4) * devicePixelRatio);
    const start = Math.min(Math.max(align === "center" ? x - width / 2 : x, left), right - width);
    const box = [start, y - 7 * devicePixelRatio, start + width, y + 7 * devicePixelRatio];
    if (taken.some((b) => box[0] < b[2] && b[0] < box[2] && box[1] < b[3] && b[1] < box[3]) || y < top || y > top + height) return false;
    taken.push(box);
    label(plot, ctx, text, start, y, "left", ink);
    return true;
  };
  const inside = (x, y) => x >= plot.shown.x[0] && x <= plot.shown.x[1] && y >= plot.shown.y[0] && y <= plot.shown.y[1];
  const { top, height } = plot.u.bbox;
  for (const point of plot.labels) if (inside(point.x, point.y)) {
    const [x, y] = [plot.toX(point.x), plot.toY(point.y)];
    ctx.strokeStyle = colour("--text");
    ctx.lineWidth = devicePixelRatio;
    ctx.beginPath();
    ctx.arc(x, y, 3 * devicePixelRatio, 0, 2 * Math.PI);
    ctx.stroke();
    const short = point.text.length > 42 ? point.text.slice(0, 41) + "…" : point.text;
    // Above the point, but below one at the foot, where a curve comes from above.
    const side = y > top + 0.8 * height && plot.curves.some((c) => c.mark === "line") ? 1 : -1;
    place(short, x, Math.max(y + side * 11 * devicePixelRatio, top + 8 * devicePixelRatio), "center", "--text");
  }
  if (!plot.at_end) return;
  const dpr = devicePixelRatio, right = plot.u.bbox.left + plot.u.bbox.width - 9 * dpr;
  const end = (curve) => {
    for (let i = curve.x.length - 1; i >= 0; i--) if (inside(curve.x[i], curve.y[i])) return { curve, x: plot.toX(curve.x[i]), y: plot.toY(curve.y[i]) };
  };
  const ends = plot.curves.filter((c) => c.name).map(end).filter(Boolean);
  // Names at the right edge keep the order of their curves; where there is no room for all, those nearest to another are left out.
  const row = 15 * dpr, edge = ends.filter((e) => e.x > right).sort((a, b) => a.y - b.y);
  while (edge.length * row > height) {
    const gaps = edge.map((e, k) => (k ? e.y - edge[k - 1].y : Infinity));
    edge.splice(gaps.indexOf(Math.min(...gaps)), 1);
  }
  edge.forEach((e, k) => (e.at = Math.max(e.y, k ? edge[k - 1].at + row : top + 0.5 * row)));
  for (let k = edge.length - 1; k >= 0; k--) edge[k].at = Math.min(edge[k].at, k + 1 < edge.length ? edge[k + 1].at - row : top + height - 0.5 * row);
  for (const { curve, x, y, at } of edge) {
    const [name, from, to] = [curve.name, x + 3 * dpr, x + 16 * dpr];
    const moved = Math.abs(at - y) > 3 * dpr;
    if (!place(name, moved ? to + 2 * dpr : x + 6 * dpr, at, "left", "--series-" + curve.ink) || !moved) continue;
    ctx.strokeStyle = plot.ink(curve);
    ctx.lineWidth = dpr;
    ctx.beginPath();
    ctx.moveTo(from, y);
    ctx.lineTo(to, at);
    ctx.stroke();
  }
  for (const { curve, x, y } of ends) if (x <= right) [-9, 9, -22, 22, -35].some((up) => place(curve.name, x + 6 * dpr, y + up * dpr, "left", "--series-" + curve.ink));
}
