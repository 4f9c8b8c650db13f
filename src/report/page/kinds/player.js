"use strict";
// The clock of moving views: at most 30 frames a second, only while visible, still where reduced motion is requested.
G.player = (host, draw, period) => {
  const PAUSE = 1000 / 30;
  const view = { phase: 0, frames: 0, visible: false, playing: !matchMedia("(prefers-reduced-motion: reduce)").matches };
  const button = G.button("", () => set(!view.playing));
  const runs = () => view.playing && view.visible && !document.hidden;
  const show = () => { view.frames++; draw(view.phase); };
  let [last, waiting] = [0, false];
  function frame(now) {
    waiting = false;
    if (!runs()) return void (last = 0);
    if (last === 0 || now - last >= PAUSE - 2) {
      if (last > 0) view.phase = (view.phase + Math.min(now - last, 200) / 1000 / period) % 1;
      last = now;
      show();
    }
    request();
  }
  function request() {
    if (waiting || !runs()) return;
    waiting = true;
    setTimeout(() => requestAnimationFrame(frame), last === 0 ? 0 : PAUSE / 2);
  }
  function set(playing) {
    view.playing = playing;
    button.textContent = playing ? "pause" : "play";
    button.setAttribute("aria-pressed", String(playing));
    request();
  }
  new IntersectionObserver((entries) => { view.visible = entries.at(-1).isIntersecting; request(); }).observe(host);
  document.addEventListener("visibilitychange", request);
  G.redraws.push(show);
  G.players.push(view);
  set(view.playing);
  return Object.assign(view, { button, show, set });
};

// A slider or a checkbox with its name; `values` are properties of the input.
G.control = (type, name, values) => {
  const input = G.element("input");
  Object.assign(input, { type, ...values });
  const label = G.element("label");
  const text = G.element("span", name);
  type === "checkbox" ? label.append(input, " ", text) : label.append(text, " ", input);
  return { input, label, text };
};

// A canvas as wide as its host and sharp on its screen; `height` takes the width, CSS pixels.
G.canvas = (host, height) => {
  const canvas = G.element("canvas");
  host.append(canvas);
  const ctx = canvas.getContext("2d");
  const fit = () => {
    const width = Math.max(host.clientWidth, 200);
    const size = [width, height(width)];
    const pixels = size.map((v) => Math.round(v * devicePixelRatio));
    if (canvas.width !== pixels[0] || canvas.height !== pixels[1]) {
      [canvas.width, canvas.height] = pixels;
      canvas.style.cssText = `width: ${size[0]}px; height: ${size[1]}px`;
    }
    ctx.setTransform(devicePixelRatio, 0, 0, devicePixelRatio, 0, 0);
    ctx.clearRect(0, 0, ...size);
    return size;
  };
  return { canvas, ctx, fit };
};

// A table of which one row is chosen, by click or by ↑ and ↓; cells are texts.
G.chooser = (host, heads, rows, first, choose) => {
  const box = G.element("div", undefined, "table chooser");
  const table = G.element("table");
  const line = (cells, kind) => {
    const row = G.element("tr");
    for (const text of cells) row.append(G.element(kind, text));
    table.append(row);
    return row;
  };
  line(heads, "th");
  const lines = rows.map((cells) => line(cells, "td"));
  const chooser = { chosen: -1 };
  chooser.set = (k) => {
    if (k < 0 || k >= lines.length) return;
    lines[chooser.chosen]?.removeAttribute("aria-selected");
    chooser.chosen = k;
    lines[k].setAttribute("aria-selected", "true");
    const [top, foot] = [lines[k].offsetTop, lines[k].offsetTop + lines[k].offsetHeight];
    if (top < box.scrollTop + 24) box.scrollTop = top - 24;
    if (foot > box.scrollTop + box.clientHeight) box.scrollTop = foot - box.clientHeight;
    choose(k);
  };
  lines.forEach((row, k) => row.addEventListener("click", () => chooser.set(k)));
  box.tabIndex = 0;
  box.setAttribute("aria-label", "↑ and ↓ choose a row");
  box.addEventListener("keydown", (event) => {
    const step = { ArrowUp: -1, ArrowDown: 1 }[event.key];
    if (step) { event.preventDefault(); chooser.set(chooser.chosen + step); }
  });
  box.append(table);
  host.append(box);
  chooser.set(first);
  return chooser;
};
