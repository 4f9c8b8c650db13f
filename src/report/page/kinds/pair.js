"use strict";
// A pair turns in mesh in space, with the curves of contact of worm and crossed pairs; next to bevel pairs both flanks with pattern, path and the contact of the moment, and the transmission error; V and H move the pinion.
G.kind("pair", (data, host) => {
  const { members, contact, loaded, curves } = data;
  const named = (name) => name[0].toUpperCase() + name.slice(1);
  const pitch = (2 * Math.PI) / members[0].teeth;
  const box = G.element("div", undefined, "turning pair");
  const bar = G.element("div", undefined, "bar");
  const both = G.element("div", undefined, "both");
  const [left, right] = [G.element("div"), G.element("div")];
  both.append(...(contact ? [left, right] : [left]));
  if (!contact) both.style.display = "block";
  box.append(bar, both);
  host.append(box);
  const angle = G.control("range", "angle", { min: 0, max: 1, step: 0.001, value: 0.5 });
  const through = G.control("checkbox", `${members[1].name} see-through`, { checked: !data.middle_m || Boolean(curves) });
  const near = G.control("checkbox", "near the contact", {});
  const readout = G.element("p", "", "note");

  // The pair in space.
  const far = members.map((m) => { let most = 0; for (let i = 0; i < m.surface.points.length; i++) most = Math.max(most, Math.abs(m.surface.points[i])); return most; });
  const axisOf = (m) => m.rotation.slice(6, 9);
  const middle = [0, 1, 2].map((k) => 0.15 * (axisOf(members[0])[k] * far[0]) + 0.1 * axisOf(members[1])[k] * far[1]);
  const home = { yaw: 0.7, tilt: 0.55, zoom: 1, centre: data.middle_m ?? middle, size: data.size_m ?? 2.15 * Math.max(...far), up: axisOf(members[1]) };
  const space = G.space(left, (width) => Math.round(Math.min(0.85 * width, 520)), home);
  space.canvas.setAttribute("aria-label", `${named(members[0].name)} (${members[0].teeth} ${members[0].name === "worm" ? "starts" : "teeth"}, blue) and ${members[1].name} (${members[1].teeth} teeth, orange) in mesh. Arrow keys turn the view, + and − zoom, 0 shows all.`);
  const bodies = members.map((m) => {
    const { points, rings, closed } = m.surface;
    const around = points.length / 3 / rings, [c, s] = [Math.cos((2 * Math.PI) / m.teeth), Math.sin((2 * Math.PI) / m.teeth)];
    const all = [];
    // A closed surface goes on to the first point of the next tooth, and back to the first ring.
    for (let i = 0; i < rings + (closed ? 1 : 0); i++) {
      const from = (i % rings) * around * 3;
      for (let k = 0; k < around; k++) all.push(points[from + 3 * k], points[from + 3 * k + 1], points[from + 3 * k + 2]);
      if (closed) all.push(c * points[from] - s * points[from + 1], s * points[from] + c * points[from + 1], points[from + 2]);
    }
    return space.mesh(all, G.gridTriangles(rings + (closed ? 1 : 0), around + (closed ? 1 : 0)));
  });

  // A place of a flank by its shares of face and height, raised above the drawn surface.
  const RAISED = 3e-4;
  function onFlank({ rows, columns, points, normals }, face, height, raised = RAISED) {
    const split = (share, count) => {
      const at = Math.min(Math.max(share, 0), 1) * (count - 1);
      const k = Math.min(Math.floor(at), count - 2);
      return [k, at - k];
    };
    const [[i, u], [j, v]] = [split(height, rows), split(face, columns)];
    return [0, 1, 2].map((k) => {
      const at = (a, b) => { const n = 3 * ((i + a) * columns + j + b) + k; return points[n] + raised * normals[n]; };
      return (1 - u) * ((1 - v) * at(0, 0) + v * at(0, 1)) + u * ((1 - v) * at(1, 0) + v * at(1, 1));
    });
  }
  const [AROUND, SHOWN] = [16, 60];
  const markOf = (member, i) => contact.marks[member].slice(6 * i, 6 * i + 6);
  const onEllipse = ([f, h, af, ah, bf, bh], k) => {
    const [c, s] = [Math.cos((2 * Math.PI * k) / AROUND), Math.sin((2 * Math.PI * k) / AROUND)];
    return [f + af * c + bf * s, h + ah * c + bh * s];
  };
  function ellipses(flank, marks, raised) {
    const [points, triangles] = [[], []];
    for (const mark of marks) {
      const from = points.length / 3;
      points.push(...onFlank(flank, mark[0], mark[1], raised));
      for (let k = 0; k < AROUND; k++) {
        points.push(...onFlank(flank, ...onEllipse(mark, k), raised));
        triangles.push(from, from + 1 + k, from + 1 + ((k + 1) % AROUND));
      }
    }
    return space.mesh(points, triangles);
  }
  // Dots of cells that carry.
  const dot = (face, height) => [face, height, 0.012, 0, 0, 0.03];

  // The state of V and H.
  const state = { index: -1, from: 0, to: 0, patterns: [null, null] };
  const [v, h] = contact ? ["V, offset", "H, pinion axial"].map((name, k) => {
    const values = [contact.offsets_m, contact.pinion_axials_m][k];
    return { values, ...G.control("range", name, { min: 0, max: values.length - 1, step: 1, value: (values.length - 1) / 2 }) };
  }) : [];
  const isMiddle = () => [v, h].every((s) => 2 * Number(s.input.value) === s.values.length - 1);
  function choose() {
    if (!contact) return;
    for (const s of [v, h]) {
      const shown = `${G.number(1e3 * s.values[s.input.value], 3)} mm`;
      s.text.textContent = `${s === v ? "V, offset" : "H, pinion axial"} ${shown}`;
      s.input.setAttribute("aria-valuetext", shown);
    }
    const index = contact.index[Number(v.input.value) * h.values.length + Number(h.input.value)];
    state.index = index ?? -1;
    state.patterns.forEach((mesh) => space.free(mesh));
    state.patterns = [null, null];
    if (state.index < 0) return;
    [state.from, state.to] = [contact.first[index], contact.first[index + 1] ?? contact.pinion_rad.length];
    const step = Math.ceil((state.to - state.from) / SHOWN);
    const chosen = [];
    for (let i = state.from; i < state.to; i += step) chosen.push(i);
    state.patterns = members.map((m, k) => m.flank && ellipses(m.flank, chosen.map((i) => markOf(k, i))));
  }

  // What touches at a phase of the pitch.
  function moment(phase) {
    if (curves) {
      // Both stand at a position of which the contact is known.
      const { first, ends } = curves, k = Math.min(Math.floor(phase * first.length), first.length - 1), touching = [];
      for (let i = first[k]; i < (first[k + 1] ?? ends.length); i++) touching.push(curves.points_m.slice(3 * (ends[i - 1] ?? 0), 3 * ends[i]));
      return { angles: curves.angles_rad.map((list) => list[k]), centres: data.centres_m, touching };
    }
    if (!contact || state.index < 0) {
      const turned = (phase - 0.5) * pitch;
      return { angles: [members[0].start_rad + turned, members[1].start_rad + data.ratio * turned], centres: data.centres_m };
    }
    const at = contact.pinion_rad[state.from] + phase * pitch;
    let i = state.from;
    while (i + 1 < state.to && contact.pinion_rad[i + 1] <= at) i++;
    const j = Math.min(i + 1, state.to - 1);
    const gap = contact.pinion_rad[j] - contact.pinion_rad[i];
    const share = gap > 0 ? Math.min((at - contact.pinion_rad[i]) / gap, 1) : 0;
    const between = (list) => list[i] + share * (list[j] - list[i]);
    const same = contact.pair[i] === contact.pair[j];
    const marks = members.map((_, k) => { const [a, b] = [markOf(k, i), markOf(k, same ? j : i)]; return a.map((x, n) => x + share * (b[n] - x)); });
    return { angles: [at, between(contact.gear_rad)], te: between(contact.te_rad), marks, pair: contact.pair[i], centres: contact.centres_m[state.index], i };
  }
  // Cells that carry at an angle of the pinion, where a load is known: positions run a pitch from the reference on.
  function cells(at) {
    if (!loaded || !isMiddle()) return [];
    const share = (at - contact.reference_rad) / pitch, turns = Math.floor(share);
    const k = Math.min(Math.floor((share - turns) * loaded.first.length), loaded.first.length - 1);
    const all = [];
    for (let i = loaded.first[k]; i < (loaded.first[k + 1] ?? loaded.pair.length); i++) all.push({ pair: loaded.pair[i] - turns, pressure: loaded.pressure_mpa[i], at: [0, 1].map((m) => [loaded.marks[m][2 * i], loaded.marks[m][2 * i + 1]]) });
    return all;
  }

  // A curve of space as a tube.
  function tube(points, radius) {
    const count = points.length / 3, at = (i) => [0, 1, 2].map((k) => points[3 * i + k]);
    const { unit, cross } = G.vectors;
    const all = [];
    let side = [0.3, 0.5, 0.8];
    for (let i = 0; i < count; i++) {
      const [p, a, b] = [at(i), at(Math.max(i - 1, 0)), at(Math.min(i + 1, count - 1))];
      const along = unit(b.map((v, k) => v - a[k])), up = unit(cross(along, side));
      side = cross(up, along);
      for (let n = 0; n <= 6; n++) all.push(...p.map((v, k) => v + radius * (Math.cos((n * Math.PI) / 3) * side[k] + Math.sin((n * Math.PI) / 3) * up[k])));
    }
    return space.mesh(all, G.gridTriangles(count, 7));
  }

  // The contact of the moment in space as a place of the flank of a member, and the direction out of its metal there.
  function touching(now, member = 0) {
    const [f, h] = now.marks[member], m = members[member], r = m.rotation;
    const a = now.angles[member] + ((member === 0 ? now.pair : -now.pair) * 2 * Math.PI) / m.teeth;
    const placed = (p) => { const q = [Math.cos(a) * p[0] - Math.sin(a) * p[1], Math.sin(a) * p[0] + Math.cos(a) * p[1], p[2]]; return [0, 1, 2].map((k) => r[k] * q[0] + r[3 + k] * q[1] + r[6 + k] * q[2] + now.centres[member][k]); };
    const [low, high] = [0, 1e-3].map((raised) => placed(onFlank(m.flank, f, h, raised)));
    return { at: low, normal: high.map((v, k) => 1e3 * (v - low[k])) };
  }

  const CURVE = 96, ROOM = 20, EDGE = 8;
  const flat = (contact ? members : []).map((m) => {
    const [xs, ys] = [0, 1].map((k) => m.corners_m.map((p) => p[k]));
    return { x: Math.min(...xs), y: Math.max(...ys), wide: Math.max(...xs) - Math.min(...xs), high: Math.max(...ys) - Math.min(...ys) };
  });
  const scaleOf = (width) => (width - 2 * EDGE) / Math.max(...flat.map((b) => b.wide));
  const { canvas, ctx, fit } = contact ? G.canvas(right, (width) => Math.round((flat[0].high + flat[1].high) * scaleOf(width) + 3 * ROOM + CURVE)) : {};
  const ARCSEC = (180 * 3600) / Math.PI;
  let marked = [];
  function draw(phase) {
    const now = moment(phase);
    const loads = contact && now.marks ? cells(now.angles[0]) : [];
    marked.forEach((mesh) => space.free(mesh));
    marked = [];
    const items = members.map((m, k) => ({ mesh: bodies[k], turn: m.rotation, centre: now.centres[k], from: now.angles[k] + m.surface.turn_rad, pitch: (2 * Math.PI) / m.teeth, count: m.teeth, ink: G.colour("--series-" + k), opacity: k === 1 && through.input.checked ? 0.3 : 1 }));
    if (now.marks) members.forEach((m, k) => {
      if (!m.flank) return;
      const own = (2 * Math.PI) / m.teeth;
      const item = { turn: m.rotation, centre: now.centres[k], pitch: own, unlit: true };
      // The pattern on the teeth about the mesh.
      const count = Math.min(m.teeth, 7), first = (k === 0 ? now.pair : -now.pair) - Math.floor(count / 2);
      items.push({ ...item, mesh: state.patterns[k], from: now.angles[k] + first * own, count, ink: G.colour("--mark") });
      // The tooth of a pair: that many pitches on for the pinion, back for the gear.
      for (const pair of loads.length ? new Set(loads.map((c) => c.pair)) : [now.pair]) {
        const list = loads.length ? loads.filter((c) => c.pair === pair) : null;
        const mesh = ellipses(m.flank, list ? list.map((c) => dot(...c.at[k])) : [now.marks[k]], 1.6 * RAISED);
        marked.push(mesh);
        items.push({ ...item, mesh, from: now.angles[k] + (k === 0 ? pair : -pair) * own, ink: G.colour("--contact") });
      }
    });
    for (const points of now.touching ?? []) {
      const mesh = tube(points, (0.004 * data.size_m) / space.zoom);
      marked.push(mesh);
      items.push({ mesh, turn: [1, 0, 0, 0, 1, 0, 0, 0, 1], centre: [0, 0, 0], from: 0, pitch: 0, unlit: true, ink: G.colour("--contact") });
    }
    if (near.input.checked && now.marks && members[0].flank) space.centre = touching(now).at;
    if (near.input.checked && now.touching?.length) space.centre = [0, 1, 2].map((k) => { const of = now.touching.flatMap((c) => Array.from(c).filter((_, i) => i % 3 === k)); return (Math.min(...of) + Math.max(...of)) / 2; });
    space.draw(items);
    if (contact) drawFlanks(now, phase, loads);
    angle.input.value = phase;
    const degrees = `${((phase * 360) / members[0].teeth).toFixed(1)}°`;
    angle.input.setAttribute("aria-valuetext", degrees);
    const peak = contact && contact.peak_to_peak_rad[state.index];
    const parts = [`${named(members[0].name)} at ${degrees} of a pitch of ${(360 / members[0].teeth).toFixed(1)}°`];
    if (now.marks) parts.push(`transmission error ${(ARCSEC * now.te).toFixed(1).replace("-", "−")} arcsec`, peak === null ? "no contact at some angles" : `peak to peak ${(ARCSEC * peak).toFixed(1)} arcsec`);
    else if (contact) parts.push("the flanks do not touch on their teeth at this V and H");
    if (curves) parts.push(`${now.touching.length} ${curves.contact}${now.touching.length === 1 ? "" : "s"} of contact`);
    if (loads.length) parts.push(`greatest pressure at this angle ${Math.round(Math.max(...loads.map((c) => c.pressure)))} N/mm² under ${G.number(loaded.torque_nm)} N·m`);
    readout.textContent = parts.join("; ") + ".";
  }

  // Both flanks in their planes, toe left and root below, and the transmission error below them.
  function drawFlanks(now, phase, loads) {
    const [width, height] = fit();
    const scale = scaleOf(width);
    const below = [ROOM, 2 * ROOM + flat[0].high * scale];
    ctx.font = "12px system-ui, sans-serif";
    members.forEach((m, k) => {
      const at = ([f, h]) => { const p = G.onCorners(m.corners_m, f, h); return [EDGE + (p[0] - flat[k].x) * scale, below[k] + (flat[k].y - p[1]) * scale]; };
      ctx.fillStyle = G.colour("--text");
      ctx.fillText(`${m.name}: toe left, root below`, EDGE, below[k] - 5);
      const trace = (places) => { ctx.beginPath(); places.forEach((p, n) => ctx[n ? "lineTo" : "moveTo"](...at(p))); };
      const ring = (mark) => trace(Array.from({ length: AROUND + 1 }, (_, n) => onEllipse(mark, n)));
      const frame = [[0, 0], [1, 0], [1, 1], [0, 1], [0, 0]];
      ctx.save();
      trace(frame);
      ctx.fillStyle = G.colour("--card");
      ctx.fill();
      ctx.clip();
      if (now.marks) {
        ctx.fillStyle = G.colour("--mark");
        for (let i = state.from; i < state.to; i++) { ring(markOf(k, i)); ctx.fill(); }
        // The path by the angle of its pair.
        const path = [];
        for (let i = state.from; i < state.to; i++) path.push([contact.pinion_rad[i] + contact.pair[i] * pitch, markOf(k, i)]);
        trace(path.sort((a, b) => a[0] - b[0]).map((p) => p[1]));
        ctx.strokeStyle = G.colour("--text");
        ctx.lineWidth = 1.2;
        ctx.stroke();
        ctx.fillStyle = G.colour("--contact");
        for (const mark of loads.length ? loads.map((c) => dot(...c.at[k])) : [now.marks[k]]) {
          ring(mark);
          ctx.fill();
          // The contact of an edge has no ellipse.
          if (mark[2] === 0 && mark[3] === 0) { ctx.beginPath(); ctx.arc(...at(mark), 4, 0, 2 * Math.PI); ctx.fill(); }
        }
      }
      ctx.restore();
      trace(frame);
      ctx.strokeStyle = G.colour("--series-" + k);
      ctx.lineWidth = 1.6;
      ctx.stroke();
    });
    if (now.marks) drawError(phase, [EDGE + 40, height - CURVE + 8, width - 2 * EDGE - 44, CURVE - 30]);
  }
  function drawError(phase, [left, top, wide, high]) {
    const list = Array.from(contact.te_rad.slice(state.from, state.to), (te) => ARCSEC * te), start = contact.pinion_rad[state.from];
    const [low, most] = [Math.min(...list), Math.max(...list)];
    const x = (share) => left + wide * share, y = (te) => top + high * (1 - (te - low) / (most - low || 1));
    ctx.strokeStyle = G.colour("--rule");
    ctx.lineWidth = 1;
    ctx.strokeRect(left, top, wide, high);
    ctx.strokeStyle = G.colour("--text");
    ctx.beginPath();
    list.forEach((te, n) => ctx[n ? "lineTo" : "moveTo"](x((contact.pinion_rad[state.from + n] - start) / pitch), y(te)));
    ctx.stroke();
    ctx.strokeStyle = ctx.fillStyle = G.colour("--contact");
    ctx.beginPath();
    ctx.moveTo(x(phase), top);
    ctx.lineTo(x(phase), top + high);
    ctx.stroke();
    ctx.fillStyle = G.colour("--text");
    ctx.textAlign = "right";
    for (const te of [low, most]) ctx.fillText(te.toFixed(1).replace("-", "−"), left - 5, y(te) + 4);
    ctx.textAlign = "left";
    ctx.fillText("transmission error over one pitch, arcsec", left, top + high + 16);
  }

  const player = G.player(box, draw, 4);
  player.touching = (phase) => members.map((_, k) => touching(moment(phase), k).at);
  bar.append(player.button, angle.label, through.label, ...(contact || curves ? [near.label] : []));
  if (contact && contact.index.length > 1) {
    const moves = G.element("div", undefined, "bar");
    moves.append(v.label, h.label);
    bar.after(moves);
  }
  box.append(readout);
  angle.input.addEventListener("input", () => { player.set(false); player.phase = Number(angle.input.value); player.show(); });
  through.input.addEventListener("change", () => player.show());
  near.input.addEventListener("change", () => { Object.assign(space, near.input.checked ? { zoom: 6 } : home); player.show(); });
  for (const s of contact ? [v, h] : []) s.input.addEventListener("input", () => { choose(); player.show(); });
  const text = [`Blue: ${members[0].name}, drives; orange: ${members[1].name}.`];
  if (curves) text.push(`Green: ${curves.contact}s of contact of the moment${curves.contact === "point" ? ", each with its ellipse" : ""}.`);
  if (contact) {
    canvas.setAttribute("role", "img");
    canvas.setAttribute("aria-label", "flanks of pinion and gear with the contact pattern, and the transmission error over one pitch");
    text.push(`Pattern: where the flanks come closer than ${G.number(1e6 * data.coating_m)} µm, the thickness of a marking compound; green: ${loaded ? "cells that carry" : "the contact of the moment"}; line: path of contact.`);
    if (contact.index.length > 1) text.push("V moves the gear off the pinion's axis, H the pinion along its own.");
  }
  text.push("Drag, or arrow keys with the picture in focus, turn the view.");
  host.append(G.element("p", text.join(" "), "note"));
  choose();
  if (space.still) player.set(false);
  player.phase = 0.5;
  // The camera looks at the flank of the pinion that touches, through the gear.
  const first = moment(0.5);
  const facing = first.marks && members[0].flank ? touching(first).normal : curves?.facing;
  if (facing) {
    const up = axisOf(members[1]);
    Object.assign(home, space.towards(facing.map((v, k) => v + 0.5 * up[k])));
    Object.assign(space, home);
  }
  player.show();
});
