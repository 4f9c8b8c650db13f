"use strict";
// Draws the figures of a report with uPlot's scales and axes; curves, maps and names are drawn here, since they have abscissae of their own.
(() => {
  const G = (globalThis.G = { plots: [], players: [], redraws: [], kinds: {} });
  const data = JSON.parse(document.getElementById("data").textContent);
  const root = document.documentElement;
  const element = (name, text, className) => {
    const made = document.createElement(name);
    if (text !== undefined) made.textContent = text;
    if (className) made.className = className;
    return made;
  };
  const button = (text, act, title = "") => {
    const made = element("button", text);
    Object.assign(made, { type: "button", title });
    made.addEventListener("click", act);
    return made;
  };
  const colour = (name) => getComputedStyle(root).getPropertyValue(name).trim();

  // Columns: differences of bit patterns, bytes ordered by significance, deflated, in base 64.
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

  // Numbers of tips and axes.
  const number = (x, digits = 6) => {
    if (!Number.isFinite(x)) return "–";
    const size = Math.abs(x);
    const text = size !== 0 && (size < 1e-4 || size >= 1e7) ? x.toExponential(Math.min(digits - 1, 4)).replace(/\.?0+e/, "e").replace("e+", "e") : String(Number(x.toPrecision(digits)));
    return text.replaceAll("-", "−");
  };
  const prefixed = (x, unit) => {
    const [size, prefix] = [[1, ""], [1e-3, "m"], [1e-6, "µ"], [1e-9, "n"], [1e-12, "p"]].find(([s]) => Math.abs(x) >= s * 0.9999) ?? [1, ""];
    return number(x / size) + " " + prefix + unit;
  };
  const axisText = (axis) => (axis.unit ? (x) => prefixed(x, axis.unit) : (x) => number(x * axis.factor));

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
    for (const share of [0, 0.25, 0.5, 0.75, 1]) {
      const level = scale[0] + share * (scale[1] - scale[0]);
      ctx.fillText(number(level, 3), from + across + 4 * dpr, top + height * (1 - share));
    }
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
    for (const curve of plot.curves) if (curve.name) {
      for (let i = curve.x.length - 1; i >= 0; i--) if (inside(curve.x[i], curve.y[i])) {
        const [x, y] = [plot.toX(curve.x[i]), plot.toY(curve.y[i])];
        const offsets = x > plot.u.bbox.left + plot.u.bbox.width - 9 * devicePixelRatio ? [0, -12, 12, -24, 24, -36, 36] : [-9, 9, -22, 22, -35];
        offsets.some((up) => place(curve.name, x + 6 * devicePixelRatio, y + up * devicePixelRatio, "left", "--series-" + curve.ink));
        break;
      }
    }
  }

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
      for (const text of split(line + (line.endsWith(",") ? "," : ""))) row.append(element(k === 0 ? "th" : "td", text));
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
  async function figure(figure, host, name) {
    if (figure.svg !== undefined) {
      const box = element("div", undefined, "drawing");
      const parsed = new DOMParser().parseFromString(await textOf(figure.svg), "image/svg+xml").documentElement;
      if (!parsed.hasAttribute("viewBox")) parsed.setAttribute("viewBox", `0 0 ${parsed.getAttribute("width")} ${parsed.getAttribute("height")}`);
      box.append(document.importNode(parsed, true));
      host.append(box);
      return;
    }
    if (figure.title) host.append(element("h3", figure.title));
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
    // Long sentences are wrapped, tables are not.
    const text = element("pre");
    for (const line of part.text.trimEnd().split("\n")) text.append(element("div", line || " ", /\S {2}/.test(line) ? "" : "prose"));
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
    document.querySelector("footer").textContent = `geardyn ${data.version}. Drag: zoom; arrow keys, + and −: move and zoom the plot in focus; 0 or double click: all; t: light and dark.`;
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
})();
