"use strict";
// Cylindrical gears turn in mesh: outlines, circles, the path of contact and the points where teeth touch.
G.kind("teeth", (data, host) => {
  const { members, path } = data;
  const [pinion, gear] = members;
  const pitch = (2 * Math.PI) / pinion.teeth;
  const NEAR = 5.2; // pitches across the picture
  const box = G.element("div", undefined, "turning");
  const bar = G.element("div", undefined, "bar");
  const angle = G.control("range", "angle", { min: 0, max: 1, step: 0.001, value: 0 });
  const whole = G.control("checkbox", "whole gears");
  const readout = G.element("span", "", "note");
  box.append(bar);
  host.append(box);
  const { canvas, ctx, fit } = G.canvas(box, (width) => Math.round(Math.min(0.6 * width, 560)));
  canvas.setAttribute("role", "img");
  canvas.setAttribute("aria-label", "teeth in mesh");

  // Metres from the pitch point: the line of centres upwards, the pinion below.
  function scaleOf(width, height) {
    if (!whole.input.checked) return Math.min(width / (NEAR * pitch * pinion.pitch_m), height / (9 * data.module_m));
    const ends = members.flatMap((m) => [-1, 1].map((s) => m.axis_m - pinion.pitch_m + s * outer(m)));
    return Math.min(width / (2 * Math.max(...members.map(outer))), height / (Math.max(...ends) - Math.min(...ends))) * 0.96;
  }
  const outer = (m) => (m.internal ? m.root_m + 2 * data.module_m : m.tip_m);
  // The outline of a gear about its axis, x to the right, y downwards, in pixels.
  function outline(member, scale) {
    const shape = new Path2D();
    for (let k = 0; k < member.teeth; k++) {
      const turn = (2 * Math.PI * k) / member.teeth;
      const [cos, sin] = [Math.cos(turn), Math.sin(turn)];
      member.tooth_m.forEach(([x, y], i) => {
        const [u, v] = [x * cos - y * sin, x * sin + y * cos];
        k + i === 0 ? shape.moveTo(-v * scale, -u * scale) : shape.lineTo(-v * scale, -u * scale);
      });
    }
    shape.closePath();
    if (member.internal) {
      shape.moveTo(outer(member) * scale, 0);
      shape.arc(0, 0, outer(member) * scale, 0, 2 * Math.PI);
    }
    return shape;
  }
  let [shapes, made] = [[], 0];

  function draw(phase) {
    const [width, height] = fit();
    const scale = scaleOf(width, height);
    if (made !== scale) [shapes, made] = [members.map((m) => outline(m, scale)), scale];
    const ends = members.flatMap((m) => [-1, 1].map((s) => m.axis_m - pinion.pitch_m + s * outer(m)));
    const middle = whole.input.checked ? 0.5 * (Math.max(...ends) + Math.min(...ends)) : 0;
    const at = (x, y) => [width / 2 + x * scale, height / 2 - (y - middle) * scale];
    const turn = phase * pitch;
    const angles = [turn, ((gear.internal ? 1 : -1) * turn * pinion.teeth) / gear.teeth];
    members.forEach((m, k) => {
      const [x, y] = at(0, m.axis_m - pinion.pitch_m);
      ctx.save();
      ctx.translate(x, y);
      for (const [radius, dash] of [[m.pitch_m, [8, 3, 2, 3]], [m.base_m, [2, 3]]]) {
        ctx.setLineDash(dash);
        ctx.lineWidth = 1;
        ctx.strokeStyle = G.colour("--quiet");
        ctx.beginPath();
        ctx.arc(0, 0, radius * scale, 0, 2 * Math.PI);
        ctx.stroke();
      }
      ctx.setLineDash([]);
      // Turning forwards is clockwise on the screen.
      ctx.rotate(angles[k]);
      ctx.fillStyle = ctx.strokeStyle = G.colour("--series-" + k);
      ctx.globalAlpha = 0.16;
      ctx.fill(shapes[k], "evenodd");
      ctx.globalAlpha = 1;
      ctx.lineWidth = 1.4;
      ctx.stroke(shapes[k]);
      ctx.restore();
    });
    const touching = contacts(turn);
    drawPath(at, touching);
    angle.input.value = phase;
    readout.textContent = `pinion at ${G.number((phase * 360) / pinion.teeth, 3)}°, ${touching.length} tooth pair${touching.length === 1 ? "" : "s"} in contact in this plane`;
  }
  const onPath = (d) => [d * Math.cos(data.pressure_angle_rad), d * Math.sin(data.pressure_angle_rad)];
  // Distances from the pitch point of the pairs that touch.
  function contacts(turn) {
    const [from, to] = [path[0].at_m, path.at(-1).at_m];
    const first = pinion.base_m * turn;
    const k = Math.ceil((from - first) / data.base_pitch_m - 1e-9);
    const all = [];
    for (let d = first + k * data.base_pitch_m; d <= to + 1e-9 * data.base_pitch_m; d += data.base_pitch_m) all.push(d);
    return all;
  }
  function drawPath(at, touching) {
    ctx.strokeStyle = ctx.fillStyle = G.colour("--text");
    ctx.lineWidth = 1.6;
    ctx.beginPath();
    ctx.moveTo(...at(...onPath(path[0].at_m)));
    ctx.lineTo(...at(...onPath(path.at(-1).at_m)));
    ctx.stroke();
    ctx.font = "11px system-ui, sans-serif";
    for (const point of whole.input.checked ? [] : path) {
      const [x, y] = at(...onPath(point.at_m));
      ctx.beginPath();
      ctx.arc(x, y, 2, 0, 2 * Math.PI);
      ctx.fill();
      ctx.fillText(point.name, x + 5, y + 12);
    }
    for (const d of touching) {
      const [x, y] = at(...onPath(d));
      ctx.beginPath();
      ctx.arc(x, y, 5, 0, 2 * Math.PI);
      ctx.fillStyle = G.colour("--series-4");
      ctx.fill();
    }
  }

  const player = G.player(box, draw, 3);
  bar.append(player.button, angle.label, whole.label, readout);
  angle.input.addEventListener("input", () => { player.set(false); player.phase = Number(angle.input.value); player.show(); });
  whole.input.addEventListener("change", () => player.show());
  host.append(G.element("p", `Blue: pinion, ${pinion.teeth} teeth, drives; orange: gear, ${gear.teeth} teeth. Dotted: base circles; chained: pitch circles; A to E: path of contact; green: where flanks touch.`, "note"));
  player.show();
});
