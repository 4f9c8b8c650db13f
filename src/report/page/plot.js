// A plot on uPlot's scales and axes; marks are drawn by the page itself, since curves, maps and names have abscissae of their own. Zoom, address, tip.
function makePlot(plot, host, group, name, numbered, padded = plot.map) {
  const width = () => host.clientWidth || 1000;
  const height = () => (plot.equal ? 620 : Math.max(plot.height, 100)) + (numbered ? 62 : 20);
  const xs = plot.curves.map((c) => c.x);
  // Room for names beyond the extremes, and for ticks of events below them.
  const NAME = 26, foot = EVENT_ROW * plot.events.length, drawn = Math.max(plot.height, 100) - foot;
  const whole = plot.map
    ? { x: [plot.map.from[0], plot.map.to[plot.map.to.length - 1]], y: [plot.map.low, plot.map.low + plot.map.rows * plot.map.step] }
    : { x: wholeRange(plot.x, xs, true), y: wholeRange(plot.y, plot.curves.flatMap((c) => [c.y, c.low, c.high]), false, plot.labels.length ? NAME / (drawn - 2 * NAME) : 0.05, foot / drawn) };
  if (!whole.x || !whole.y) {
    host.append(element("p", plot.empty, "note"));
    return;
  }
  if (plot.equal) equalise(whole, (width() - 100) / 620);
  // Room for the names of curves that end at the right.
  plot.margin = Math.max(padded ? 84 : 24, ...plot.curves.map((c) => (plot.at_end ? Math.min(14 + 6.2 * c.name.length, 200) : 0)));
  Object.assign(plot, { name, group, whole, shown: { x: whole.x.slice(), y: whole.y.slice() }, host });
  plot.curves.forEach((c) => (c.rising = isRising(c.x)));
  plot.ink = (curve) => colour("--series-" + curve.ink);
  const grid = { stroke: () => colour("--grid"), width: 1 };
  const axis = (of, side) => ({
    scale: side, label: numbered || side === "y" ? of.label : undefined, labelSize: 22, size: side === "y" ? (u, texts) => Math.max(66, 30 + 6.5 * Math.max(...(texts ?? []).map((text) => text?.length ?? 0))) : numbered ? 40 : 12, stroke: () => colour("--text"), grid, ticks: grid,
    font: "12px system-ui, sans-serif", labelFont: "12px system-ui, sans-serif",
    values: (_, splits) => splits.map((v) => (v === null || !(numbered || side === "y") ? "" : axisText(of)(v))),
    ...(of.log ? { splits: (u, i, low, high) => logSplits(low, high, (side === "y" ? u.over.clientHeight : u.over.clientWidth) || 400, side === "x" && of.unit ? 200 : 90), filter: (u, splits) => splits } : {}),
    ...(of.ticks.length ? { splits: () => of.ticks } : {}),
  });
  const scale = (of, side) => ({ time: false, distr: of.log ? 3 : 1, log: 10, range: () => plot.shown[side] });
  const u = new uPlot(
    {
      width: width(), height: height(), legend: { show: false }, padding: [8, plot.margin, 0, 0],
      scales: { x: scale(plot.x, "x"), y: scale(plot.y, "y") },
      axes: [axis(plot.x, "x"), axis(plot.y, "y")],
      series: [{}, { show: true, stroke: "transparent", paths: () => null, points: { show: false } }],
      cursor: { y: true, points: { show: false }, drag: { x: true, y: true, uni: 30, setScale: false } },
      hooks: {
        drawClear: [(u) => { plot.u = u; clip(u, () => drawBehind(plot, u.ctx)); }],
        drawAxes: [(u) => { if (plot.map) { clip(u, () => drawMap(plot, u.ctx)); drawScale(plot, u.ctx); } }],
        draw: [(u) => { plot.u = u; clip(u, () => drawGuides(plot, u.ctx)); clip(u, () => plot.curves.forEach((c) => drawCurve(plot, u.ctx, c))); u.ctx.globalAlpha = 1; clip(u, () => drawEvents(plot, u.ctx)); u.ctx.globalAlpha = 1; drawNames(plot, u.ctx); frame(u); }],
        setSelect: [(u) => {
          if (u.select.width < 4 && u.select.height < 4) return;
          const { left, top, width, height } = u.select;
          const [x, y] = [[u.posToVal(left, "x"), u.posToVal(left + width, "x")], [u.posToVal(top + height, "y"), u.posToVal(top, "y")]];
          u.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
          show(plot, width < 4 ? plot.shown.x : x, height < 4 || height >= u.over.clientHeight - 1 ? plot.shown.y : y);
        }],
      },
    },
    [whole.x, whole.y],
    host,
  );
  plot.u = u;
  plot.toX = (v) => u.valToPos(v, "x", true);
  plot.toY = (v) => u.valToPos(v, "y", true);
  u.redraw();
  addEventListener("resize", () => u.setSize({ width: width(), height: height() }));
  u.over.addEventListener("mousemove", (event) => tip(plot, event));
  u.over.addEventListener("mouseleave", () => (document.getElementById("tip").hidden = true));
  u.over.addEventListener("dblclick", () => reset(plot));
  host.addEventListener("wheel", (event) => {
    if (document.activeElement !== host) return;
    event.preventDefault();
    zoom(plot, event.deltaY < 0 ? 0.8 : 1.25);
  }, { passive: false });
  host.tabIndex = 0;
  host.setAttribute("role", "img");
  host.setAttribute("aria-label", `${plot.heading || plot.y.label} over ${plot.x.label}`);
  host.addEventListener("keydown", (event) => {
    const act = { ArrowLeft: () => pan(plot, -0.2), ArrowRight: () => pan(plot, 0.2), "+": () => zoom(plot, 0.7), "-": () => zoom(plot, 1 / 0.7), 0: () => reset(plot) }[event.key];
    if (act) { event.preventDefault(); act(); }
  });
  const tools = element("div", undefined, "tools");
  if (plot.x.label === "time, s") tools.append(G.spectrumButton(plot, host), " ");
  tools.append(button("all", () => reset(plot), "show all (key 0)"), " ", button("CSV", () => download(plot.name + ".csv", G.csv(plot))));
  host.append(tools);
  G.plots.push(plot);
}

// Ranges.
function extent(lists, positive) {
  let [low, high] = [Infinity, -Infinity];
  for (const values of lists) for (let i = 0; i < values.length; i++) {
    const v = values[i];
    if (!Number.isFinite(v) || (positive && v <= 0)) continue;
    if (v < low) low = v;
    if (v > high) high = v;
  }
  return low <= high ? [low, high] : null;
}
function wholeRange(axis, lists, tight, share = 0.05, foot = 0) {
  if (axis.range) return axis.range.slice();
  const found = extent(lists, axis.log);
  if (!found) return null;
  let [low, high] = found;
  if (axis.log) {
    low = Math.max(low, high * 1e-8);
    const room = Math.max((high / low) ** (share + 0.01), 10 ** 0.1);
    return [low / room, high * room];
  }
  if (tight && low < high) return [low, high];
  const room = share * (high > low ? high - low : Math.max(Math.abs(high), 1));
  return [low - room - foot * (high - low + 2 * room), high + room];
}

// Both ranges about their middles, so that a unit has the same length on both axes of a plot this many times wider than high.
function equalise(ranges, wide) {
  const [x, y] = [ranges.x, ranges.y];
  const unit = Math.max((x[1] - x[0]) / wide, y[1] - y[0]);
  const about = ([low, high], length) => [0.5 * (low + high - length), 0.5 * (low + high + length)];
  [ranges.x, ranges.y] = [about(x, unit * wide), about(y, unit)];
}
// Plots of a group share the union of their whole ranges.
function join(plots) {
  const ends = [0, 1].map((k) => plots.map((p) => p.whole.x[k]));
  const whole = [Math.min(...ends[0]), Math.max(...ends[1])];
  for (const p of plots) {
    [p.whole.x, p.shown.x] = [whole.slice(), whole.slice()];
    p.u.redraw(true, true);
    p.u.setScale("x", { min: whole[0], max: whole[1] });
  }
}
function clip(u, draw) {
  const { left, top, width, height } = u.bbox;
  u.ctx.save();
  u.ctx.beginPath();
  u.ctx.rect(left, top, width, height);
  u.ctx.clip();
  draw();
  u.ctx.restore();
}
function frame(u) {
  const { left, top, width, height } = u.bbox;
  u.ctx.setLineDash([]);
  u.ctx.lineWidth = 1;
  u.ctx.strokeStyle = colour("--rule");
  u.ctx.strokeRect(left, top, width, height);
}
// Labels of a logarithmic axis: 1, 2 and 5 of each decade where it has room for three of them.
function logSplits(low, high, room, three) {
  const [first, last] = [Math.floor(Math.log10(low)), Math.ceil(Math.log10(high))];
  const digits = room / Math.log10(high / low) > three ? [1, 2, 5] : [1];
  const every = Math.max(1, Math.ceil((last - first) / 9));
  const all = [];
  for (let d = first; d <= last; d += every) for (const digit of digits) all.push(digit * 10 ** d);
  return all.filter((v) => v >= low * (1 - 1e-9) && v <= high * (1 + 1e-9));
}

// Ranges shown; plots of a group share their abscissa, and the address holds what differs from the whole.
function show(plot, x, y) {
  plot.shown = { x, y };
  const others = plot.group === null ? [] : G.plots.filter((p) => p !== plot && p.group === plot.group);
  for (const p of [plot, ...others]) {
    p.shown.x = x.slice();
    p.u.redraw(true, true);
    p.u.setScale("x", { min: x[0], max: x[1] });
    p.u.setScale("y", { min: p.shown.y[0], max: p.shown.y[1] });
    p.follow?.();
  }
  writeAddress();
}
const along = (axis, range, f) => (axis.log ? f(range.map(Math.log10)).map((v) => 10 ** v) : f(range));
const zoom = (plot, by) => show(plot, along(plot.x, plot.shown.x, ([a, b]) => [0.5 * (a + b) - 0.5 * by * (b - a), 0.5 * (a + b) + 0.5 * by * (b - a)]), plot.shown.y);
const pan = (plot, by) => show(plot, along(plot.x, plot.shown.x, ([a, b]) => [a + by * (b - a), b + by * (b - a)]), plot.shown.y);
function reset(plot) {
  const group = plot.group === null ? [plot] : G.plots.filter((p) => p.group === plot.group);
  for (const p of group) p.shown.y = p.whole.y.slice();
  show(plot, plot.whole.x.slice(), plot.whole.y.slice());
}
let ready = false;
function writeAddress() {
  if (!ready) return;
  const changed = G.plots.filter((p) => p.shown.x.some((v, i) => v !== p.whole.x[i]) || p.shown.y.some((v, i) => v !== p.whole.y[i]));
  const text = changed.map((p) => `${p.name}=${[...p.shown.x, ...p.shown.y].map((v) => Number(v.toPrecision(8))).join(":")}`).join("&");
  history.replaceState(null, "", text ? "#" + text : location.pathname + location.search);
}
function readAddress() {
  for (const part of location.hash.slice(1).split("&")) {
    const [name, range] = part.split("=");
    const plot = G.plots.find((p) => p.name === name);
    const values = (range ?? "").split(":").map(Number);
    if (plot && values.length === 4 && values.every(Number.isFinite)) show(plot, values.slice(0, 2), values.slice(2));
  }
}

// The nearest point.
function tip(plot, event) {
  const box = plot.u.over.getBoundingClientRect();
  const [mx, my] = [event.clientX - box.left, event.clientY - box.top];
  let best = { distance: 18 };
  const toX = (v) => plot.u.valToPos(v, "x");
  const toY = (v) => plot.u.valToPos(v, "y");
  for (const curve of plot.curves) {
    let [from, to] = [0, curve.x.length];
    if (curve.rising && to > 2000) {
      from = search(curve.x, plot.u.posToVal(mx - 18, "x"));
      to = search(curve.x, plot.u.posToVal(mx + 18, "x"));
    }
    for (let i = from; i < to; i++) {
      const distance = Math.hypot(toX(curve.x[i]) - mx, toY(curve.y[i]) - my);
      if (distance < best.distance) best = { distance, curve, i };
    }
  }
  let text = eventAt(plot, mx, my);
  if (!text && best.curve) {
    const { curve, i } = best;
    const near = plot.labels.find((l) => l.x === curve.x[i] && l.y === curve.y[i]);
    const interval = curve.low.length ? ` (${axisText(plot.y)(curve.low[i])} … ${axisText(plot.y)(curve.high[i])})` : "";
    text = `${near ? near.text + "\n" : curve.name ? curve.name + "\n" : ""}${plot.x.label}: ${axisText(plot.x)(curve.x[i])}\n${plot.y.label}: ${axisText(plot.y)(curve.y[i])}${interval}${curve.along ? `\n${curve.along.label}: ${number(curve.along.values[i])}` : ""}`;
  } else if (!text && plot.map) {
    const { map } = plot;
    const [x, y] = [plot.u.posToVal(mx, "x"), plot.u.posToVal(my, "y")];
    const i = map.from.findIndex((f, k) => x >= f && x <= map.to[k]);
    const k = Math.floor((y - map.low) / map.step);
    if (i >= 0 && k >= 0 && k < map.rows) text = `${plot.x.label}: ${number(x)}\n${plot.y.label}: ${number(y)}\n${map.label}: ${number(map.levels[i * map.rows + k])}`;
  }
  showTip(text, event);
}
function showTip(text, event) {
  const box = document.getElementById("tip");
  box.hidden = !text;
  box.textContent = text;
  box.style.left = Math.min(event.pageX + 14, scrollX + innerWidth - box.offsetWidth - 8) + "px";
  box.style.top = event.pageY + 14 + "px";
}
