"use strict";
// A mode chosen from a table moves on the points of a test; the structure is turned by dragging and by the arrow keys.
G.kind("points", (data, host) => {
  const { points, lines, modes, measured } = data;
  const [AMPLITUDE, STEP] = [0.12, Math.PI / 36]; // of the size of the structure; rad
  const home = [Math.PI / 6, (25 * Math.PI) / 180];
  let [azimuth, elevation] = home;
  let shape = null;
  const at = points.map((_, k) => data.at_m.slice(3 * k, 3 * k + 3));
  const ends = [0, 1, 2].map((axis) => [Math.min(...at.map((p) => p[axis])), Math.max(...at.map((p) => p[axis]))]);
  const centre = ends.map(([low, high]) => (low + high) / 2);
  const size = Math.hypot(...ends.map(([low, high]) => high - low)) || 1;

  const { canvas, ctx, fit, player, choose } = G.modeView(host, modes, (width) => Math.min(Math.max(0.6 * width, 220), 460), draw);
  canvas.tabIndex = 0;
  canvas.style.touchAction = "none";

  const project = ([x, y, z]) => {
    const away = -x * Math.sin(azimuth) + y * Math.cos(azimuth);
    return [x * Math.cos(azimuth) + y * Math.sin(azimuth), away * Math.sin(elevation) + z * Math.cos(elevation)];
  };
  // Components of a mode, the largest of them 1 and real.
  function take(k) {
    const all = points.flatMap((_, p) => [0, 1, 2].map((axis) => { const i = 3 * (k * points.length + p) + axis; return [data.real[i], data.imaginary[i]]; }));
    const [re, im] = all.reduce((a, b) => (Math.hypot(...b) > Math.hypot(...a) ? b : a), [0, 0]);
    const square = re * re + im * im || 1;
    return all.map(([a, b]) => [(a * re + b * im) / square, (b * re - a * im) / square]);
  }
  let spots = [];
  function draw(phase) {
    if (!shape) return;
    const [width, height] = fit();
    const angle = 2 * Math.PI * phase;
    const spread = ends.map(([low, high]) => high - low);
    const reach = [0, 1].map((axis) => 2 * AMPLITUDE * size + [0, 1, 2].reduce((sum, k) => sum + Math.abs(project([0, 1, 2].map((i) => (i === k ? spread[k] : 0)))[axis]), 0));
    const scale = Math.min((width - 20) / reach[0], (height - 30) / reach[1]);
    const place = (p) => { const [x, y] = project(p.map((v, k) => v - centre[k])); return [width / 2 + scale * x, height / 2 - scale * y]; };
    const moved = at.map((p, k) => p.map((v, axis) => { const [re, im] = shape[3 * k + axis]; return v + AMPLITUDE * size * (re * Math.cos(angle) - im * Math.sin(angle)); }));
    const rest = at.map(place);
    spots = moved.map(place);
    const path = (line, spots) => { ctx.beginPath(); line.forEach((k, i) => ctx[i ? "lineTo" : "moveTo"](...spots[k])); ctx.stroke(); };
    ctx.lineJoin = "round";
    for (const [where, colour, thick] of [[rest, "--rule", 1.2], [spots, "--series-0", 2.2]]) {
      ctx.strokeStyle = G.colour(colour);
      ctx.lineWidth = thick;
      lines.forEach((line) => path(line, where));
    }
    points.forEach((_, k) => {
      if (!lines.length) { ctx.strokeStyle = G.colour("--series-0"); path([0, 1], [rest[k], spots[k]]); }
      ctx.beginPath();
      ctx.arc(...spots[k], measured[k] ? 3.4 : 3, 0, 2 * Math.PI);
      ctx.fillStyle = ctx.strokeStyle = G.colour(measured[k] ? "--series-0" : "--quiet");
      ctx.lineWidth = 1;
      if (measured[k]) ctx.fill(); else ctx.stroke();
    });
    ctx.fillStyle = ctx.strokeStyle = G.colour("--quiet");
    ctx.font = "11px system-ui, sans-serif";
    ctx.textAlign = "center";
    if (points.length <= 40) points.forEach((name, k) => ctx.fillText(name.length > 12 ? `${name.slice(0, 11)}…` : name, rest[k][0], rest[k][1] + (spots[k][1] > rest[k][1] + 1 ? -7 : 15)));
    ["x", "y", "z"].forEach((name, axis) => {
      const [x, y] = project([0, 1, 2].map((i) => (i === axis ? 1 : 0)));
      const origin = [34, height - 34];
      path([0, 1], [origin, [origin[0] + 22 * x, origin[1] - 22 * y]]);
      ctx.fillText(name, origin[0] + 30 * x, origin[1] - 30 * y + 4);
    });
  }

  function turn(across, up) {
    azimuth -= across;
    elevation = Math.min(Math.max(elevation + up, -Math.PI / 2), Math.PI / 2);
    player.show();
  }
  canvas.addEventListener("pointerdown", (event) => canvas.setPointerCapture(event.pointerId));
  canvas.addEventListener("pointermove", (event) => {
    if (event.buttons & 1) return turn(event.movementX / 150, event.movementY / 150);
    const near = spots.findIndex(([x, y]) => Math.hypot(event.offsetX - x, event.offsetY - y) < 8);
    const value = ([re, im]) => `${G.number(re, 3)} + ${G.number(im, 3)} i`;
    G.tip(near < 0 ? "" : `${points[near]}\n${measured[near] ? ["x", "y", "z"].map((axis, k) => `${axis}: ${value(shape[3 * near + k])}`).join("\n") : "not measured"}`, event);
  });
  canvas.addEventListener("pointerleave", (event) => G.tip("", event));
  canvas.addEventListener("dblclick", () => { [azimuth, elevation] = home; player.show(); });
  canvas.addEventListener("keydown", (event) => {
    const step = { ArrowLeft: [-STEP, 0], ArrowRight: [STEP, 0], ArrowUp: [0, -STEP], ArrowDown: [0, STEP] }[event.key];
    if (step) { event.preventDefault(); event.stopPropagation(); turn(...step); }
  });
  choose(0, (k) => {
    shape = take(k);
    return `Mode ${modes[k].mode}, ${G.number(modes[k].frequency_hz)} Hz: grey at rest; rings are points that were not measured. Drag or ← → ↑ ↓ turn, a double click turns back.`;
  });
});
