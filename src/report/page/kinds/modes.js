"use strict";
// A mode chosen from a table moves in a schematic of the drive train, seen along the shafts; rotations are divided by the ratio to the first node.
G.kind("modes", (data, host) => {
  const { train, modes } = data;
  const count = train.dofs.length;
  const byName = new Map(train.nodes.map((n) => [n.name, n]));
  const inStage = new Map();
  for (const stage of train.stages) for (const role of ["sun", "ring", "carrier"]) if (stage[role] !== null && !inStage.has(stage[role])) inStage.set(stage[role], { stage, role });
  const planets = new Set(train.stages.flatMap((s) => s.planets));
  const cells = [0, 1].map((axis) => Math.max(...train.nodes.map((n) => n.place[axis] + 1), ...train.stages.map((s) => s.place[axis] + 3)));
  const SWING = 0.9; // rad
  const ROOM = 0.22; // cells round the schematic, for what moves
  let shape = null;

  // The shape of a mode: rotations and displacements, each relative to its largest; those of rounding are zero.
  function take(k) {
    const at = (i) => (i === undefined ? [0, 0] : [data.real[k * count + i], data.imaginary.length ? data.imaginary[k * count + i] : 0]);
    const all = train.nodes.map((node) => {
      const d = node.dofs;
      const turn = at(d.theta ?? (node.kind === "slide" ? d.z : undefined)).map((v) => v / (node.ratio ?? 1));
      return { node, turn, x: at(d.x), y: at(d.y), z: node.kind === "slide" ? [0, 0] : at(d.z), tilt: [at(d.ry), at(d.rx).map((v) => -v)] };
    });
    const size = ([re, im]) => Math.hypot(re, im);
    const largest = (of) => Math.max(0, ...all.flatMap(of).map(size));
    const sizes = { turn: largest((n) => [n.turn]), move: largest((n) => [n.x, n.y, n.z]), tilt: largest((n) => n.tilt) };
    const most = Math.max(...Object.values(sizes));
    const scale = (s) => (s > 1e-9 * most ? 1 / s : 0);
    const lead = all.map((n) => n.turn).concat(all.flatMap((n) => [n.x, n.y])).reduce((a, b) => (size(b) > size(a) * (1 + 1e-9) ? b : a));
    const phase = size(lead) > 0 ? Math.atan2(lead[1], lead[0]) : 0;
    return { all, sizes, phase, turn: scale(sizes.turn), move: scale(sizes.move), tilt: scale(sizes.tilt), k };
  }
  const valueAt = ([re, im], angle) => re * Math.cos(angle) - im * Math.sin(angle);

  const cell = (width) => Math.min(Math.max(width / (cells[0] + 2 * ROOM), 46), 120);
  const { canvas, ctx, fit, choose } = G.modeView(host, modes, (width) => Math.ceil(cell(width) * (cells[1] + 2 * ROOM)), draw);

  const tone = (value) => G.colour(value < 0 ? "--series-1" : "--series-0");
  function disc(x, y, r, value, angle, { gear = false, hub = [0, 0] } = {}) {
    ctx.beginPath();
    ctx.arc(x, y, r, 0, 2 * Math.PI);
    ctx.fillStyle = G.colour("--paper");
    ctx.fill();
    ctx.globalAlpha = 0.12 + 0.7 * Math.min(Math.abs(value), 1);
    ctx.fillStyle = Math.abs(value) < 1e-9 ? G.colour("--rule") : tone(value);
    ctx.fill();
    ctx.globalAlpha = 1;
    rim(x, y, r, angle, gear);
    ctx.beginPath();
    ctx.moveTo(x + hub[0], y + hub[1]);
    ctx.lineTo(x + r * Math.sin(-angle), y - r * Math.cos(angle));
    ctx.lineWidth = 2;
    ctx.stroke();
    ctx.beginPath();
    ctx.arc(x + hub[0], y + hub[1], Math.max(0.12 * r, 2), 0, 2 * Math.PI);
    ctx.fillStyle = G.colour("--text");
    ctx.fill();
  }
  // The rim, of gears with teeth that turn.
  function rim(x, y, r, angle, gear) {
    ctx.strokeStyle = G.colour("--text");
    ctx.lineWidth = 1.3;
    ctx.beginPath();
    ctx.arc(x, y, r, 0, 2 * Math.PI);
    ctx.stroke();
    if (!gear) return;
    const teeth = Math.max(Math.round((2 * Math.PI * r) / 7), 8);
    const pitch = (2 * Math.PI * r) / teeth;
    ctx.setLineDash([pitch / 2, pitch / 2]);
    ctx.lineDashOffset = angle * r;
    ctx.lineWidth = 3.5;
    ctx.stroke();
    ctx.setLineDash([]);
    ctx.lineDashOffset = 0;
  }
  function ground(x, y, across) {
    ctx.strokeStyle = G.colour("--quiet");
    ctx.lineWidth = 1.2;
    ctx.beginPath();
    ctx.moveTo(x - across, y);
    ctx.lineTo(x + across, y);
    for (let k = -2; k < 3; k++) { ctx.moveTo(x + (k * across) / 2.5, y); ctx.lineTo(x + (k * across) / 2.5 - 4, y + 5); }
    ctx.stroke();
  }

  function draw(phase) {
    if (!shape) return;
    const [width] = fit();
    const s = cell(width);
    ctx.translate(ROOM * s, ROOM * s);
    const angle = 2 * Math.PI * phase - shape.phase;
    const spread = (of, scale) => valueAt(of, angle) * scale;
    const moved = shape.all.map(({ node, turn, x, y, z, tilt }) => {
      const value = spread(turn, shape.turn);
      const move = [x, y, z].map((part) => spread(part, shape.move) * 0.2 * s);
      const home = inStage.get(node.name);
      const place = home ? home.stage.place.map((p) => p + 1.5) : node.place.map((p) => p + 0.5);
      return {
        node, value, move, at: [place[0] * s + move[0] + (node.kind === "slide" ? 0.2 * s * value * Math.sign(node.ratio ?? 1) : 0), place[1] * s - move[1]], turn: SWING * value * Math.sign(node.ratio ?? 1),
        radius: node.radius * s * (1 + move[2] / s), hub: tilt.map((part, i) => spread(part, shape.tilt) * 0.16 * s * (i ? -1 : 1)),
      };
    });
    const of = (name) => moved[train.nodes.indexOf(byName.get(name))];
    const reach = (name) => {
      const home = inStage.get(name);
      return home ? radius(home.stage, home.role, s) : of(name).radius;
    };
    train.links.forEach((link, i) => drawLink(link, data.strain[shape.k * train.links.length + i] ?? 0, of, reach, s));
    for (const stage of train.stages) drawStage(stage, of, s);
    for (const m of moved) {
      const { node } = m;
      if (inStage.has(node.name) || planets.has(node.name)) continue;
      if (node.kind === "slide") slide(m, s);
      else disc(...m.at, m.radius, m.value, m.turn, { gear: train.links.some((l) => l.mesh && l.nodes.includes(node.name)), hub: m.hub });
    }
    ctx.textAlign = "center";
    for (const m of moved) if (!planets.has(m.node.name) && !inStage.has(m.node.name)) name(m.node.name, m.node.place[0] * s + 0.5 * s, m.node.place[1] * s + 9, s);
    for (const stage of train.stages) name(["sun", "ring", "carrier"].map((r) => stage[r] ?? `${r} fixed`).join(" · "), (stage.place[0] + 1.5) * s, stage.place[1] * s + 9, 3 * s);
    for (const m of moved) m.node.drawn = planets.has(m.node.name) ? m.node.drawn : [...m.at, m.radius];
  }
  function name(text, x, y, room) {
    ctx.font = "11px system-ui, sans-serif";
    let short = text;
    while (short.length > 3 && ctx.measureText(short).width > room - 4) short = short.slice(0, -2) + "…";
    ctx.lineWidth = 3;
    ctx.strokeStyle = G.colour("--paper");
    ctx.strokeText(short, x, y);
    ctx.fillStyle = G.colour("--text");
    ctx.fillText(short, x, y);
  }
  function slide({ at: [x, y], value }, s) {
    const [w, h] = [0.56 * s, 0.36 * s];
    ctx.globalAlpha = 0.12 + 0.7 * Math.abs(value);
    ctx.fillStyle = tone(value);
    ctx.fillRect(x - w / 2, y - h / 2, w, h);
    ctx.globalAlpha = 1;
    ctx.strokeStyle = G.colour("--text");
    ctx.lineWidth = 1.3;
    ctx.strokeRect(x - w / 2, y - h / 2, w, h);
  }
  // Width by the share of the strain energy.
  function drawLink(link, share, of, reach, s) {
    ctx.strokeStyle = G.colour("--quiet");
    ctx.lineWidth = 2 + 10 * Math.abs(share);
    ctx.lineCap = "round";
    ctx.setLineDash(["damper", "brake", "bearing"].includes(link.kind) ? [3, 4 + ctx.lineWidth] : []);
    if (link.nodes.length === 1) {
      const { at, radius, node } = of(link.nodes[0]);
      // Supports of members of a stage would cross it.
      if (inStage.has(node.name)) return void ctx.setLineDash([]);
      const y = node.place[1] * s + 0.5 * s + Math.min(radius + 0.14 * s, 0.5 * s - 6);
      ctx.beginPath();
      ctx.moveTo(...at);
      ctx.lineTo(node.place[0] * s + 0.5 * s, y);
      ctx.stroke();
      ctx.setLineDash([]);
      return ground(node.place[0] * s + 0.5 * s, y, 0.13 * s);
    }
    const [a, b] = link.nodes.map(of);
    const [from, to] = [a.at, b.at];
    const length = Math.hypot(to[0] - from[0], to[1] - from[1]) || 1;
    const ahead = [(to[0] - from[0]) / length, (to[1] - from[1]) / length];
    const ends = link.nodes.map((n) => (inStage.has(n) || link.mesh ? reach(n) - (link.mesh ? 4 : 0) : 0));
    if (link.kind === "belt") {
      for (const sign of [-1, 1]) line([from[0] - sign * ahead[1] * a.radius, from[1] + sign * ahead[0] * a.radius], [to[0] - sign * ahead[1] * b.radius, to[1] + sign * ahead[0] * b.radius]);
    } else line([from[0] + ahead[0] * ends[0], from[1] + ahead[1] * ends[0]], [to[0] - ahead[0] * ends[1], to[1] - ahead[1] * ends[1]]);
    ctx.setLineDash([]);
  }
  function line(from, to) {
    ctx.beginPath();
    ctx.moveTo(...from);
    ctx.lineTo(...to);
    ctx.stroke();
  }
  const RING = 1.3;
  const radius = (stage, role, s) => RING * s * { sun: stage.radii[0], ring: 1, carrier: stage.radii[3] }[role];
  function drawStage(stage, of, s) {
    const centre = stage.place.map((p) => (p + 1.5) * s);
    const still = { value: 0, turn: 0, move: [0, 0, 0], hub: [0, 0] };
    const [sun, ring, carrier] = ["sun", "ring", "carrier"].map((r) => (stage[r] === null ? still : of(stage[r])));
    const at = (m) => [centre[0] + m.move[0], centre[1] - m.move[1]];
    const [R, orbit] = [RING * s, radius(stage, "carrier", s)];
    // The ring: an annulus.
    ctx.beginPath();
    ctx.arc(...at(ring), R + 0.13 * s, 0, 2 * Math.PI);
    ctx.arc(...at(ring), R, 0, 2 * Math.PI, true);
    ctx.globalAlpha = Math.abs(ring.value) < 1e-9 ? 0.6 : 0.15 + 0.7 * Math.abs(ring.value);
    ctx.fillStyle = Math.abs(ring.value) < 1e-9 ? G.colour("--rule") : tone(ring.value);
    ctx.fill();
    ctx.globalAlpha = 1;
    rim(...at(ring), R, ring.turn, true);
    line([at(ring)[0] - R * Math.sin(ring.turn), at(ring)[1] - R * Math.cos(ring.turn)], [at(ring)[0] - (R + 0.13 * s) * Math.sin(ring.turn), at(ring)[1] - (R + 0.13 * s) * Math.cos(ring.turn)]);
    // The carrier: arms to the seats of the planets.
    ctx.strokeStyle = Math.abs(carrier.value) < 1e-9 ? G.colour("--quiet") : tone(carrier.value);
    ctx.globalAlpha = 0.3 + 0.7 * Math.abs(carrier.value);
    ctx.lineWidth = 0.16 * s;
    for (const position of stage.positions_rad) {
      const seat = position + carrier.turn;
      line(at(carrier), [at(carrier)[0] + orbit * Math.cos(seat), at(carrier)[1] - orbit * Math.sin(seat)]);
    }
    ctx.globalAlpha = 1;
    stage.planets.forEach((planet, k) => {
      const m = of(planet);
      const position = stage.positions_rad[k];
      const [cos, sin] = [Math.cos(position), Math.sin(position)];
      const seat = stage.lateral ? position : position + carrier.turn;
      const [x, y] = [centre[0] + orbit * Math.cos(seat), centre[1] - orbit * Math.sin(seat)];
      const place = [x + m.move[0] * cos - m.move[1] * sin, y - m.move[0] * sin - m.move[1] * cos];
      const r = RING * s * stage.radii[1] - 4;
      disc(...place, r, m.value, m.turn, { gear: true, hub: m.hub });
      m.node.drawn = [...place, r];
    });
    disc(...at(sun), RING * s * stage.radii[0] - 4, sun.value, sun.turn, { gear: true, hub: sun.hub });
  }

  // The values of the node under the pointer.
  canvas.addEventListener("mousemove", (event) => {
    const room = ROOM * cell(canvas.clientWidth);
    const near = shape && train.nodes.filter((n) => n.drawn && Math.hypot(event.offsetX - room - n.drawn[0], event.offsetY - room - n.drawn[1]) <= n.drawn[2]).at(-1);
    const at = near && Object.entries(near.dofs).map(([axis, i]) => `${near.name}.${axis}: ${G.number(data.real[shape.k * count + i])}${data.imaginary.length ? ` + ${G.number(data.imaginary[shape.k * count + i])} i` : ""}`);
    G.tip(at ? at.join("\n") : "", event);
  });
  canvas.addEventListener("mouseleave", (event) => G.tip("", event));

  const caption = (k) => {
    shape = take(k);
    const m = modes[k];
    const ratio = shape.move && shape.turn ? ` Largest displacement ${G.number((1e3 * shape.sizes.move) / shape.sizes.turn, 3)} µm where the largest rotation is 1 mrad.` : "";
    const divided = train.nodes[0].ratio === null ? "" : ` Rotations divided by the ratio to ${train.nodes[0].name}.`;
    return `Mode ${m.mode}${m.frequency_hz === null ? "" : `, ${G.number(m.frequency_hz)} Hz`}${m.rigid ? ", rigid body" : ""}: blue turns forwards while orange turns backwards, links thick by their share of the strain energy.${divided}${ratio}`;
  };
  choose(data.first, caption, [["dominant element", (m) => m.dominant]]);
});
