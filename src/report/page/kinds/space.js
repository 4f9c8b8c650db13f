"use strict";
// Bodies in space by WebGL 2: surfaces that repeat about their z axis, seen from a camera that mouse, touch and keys turn; a still picture where WebGL 2 is missing.
G.space = (host, height, home) => {
  const canvas = G.element("canvas");
  canvas.className = "space";
  host.append(canvas);
  const gl = canvas.getContext("webgl2", { alpha: false, preserveDrawingBuffer: true });
  const view = { canvas, still: !gl, ...home };
  if (!gl) host.append(G.element("p", "Without WebGL 2 the picture does not turn by itself; sliders and keys draw it.", "note"));
  canvas.tabIndex = 0;
  canvas.setAttribute("role", "img");

  const { cross, dot, unit } = G.vectors;
  // Directions across the axis that points up: the camera is turned about it, then tilted.
  function base(up) {
    const side = unit(cross(Math.abs(up[0]) < 0.9 ? [1, 0, 0] : [0, 1, 0], up));
    return [up, side, cross(up, side)];
  }
  // Yaw and tilt of a camera that lies in a direction from the centre.
  view.towards = (direction) => {
    const [z, x, y] = base(view.up).map((axis) => dot(axis, unit(direction)));
    return { yaw: Math.atan2(y, x), tilt: Math.asin(z) };
  };
  function camera(width, high) {
    const [cy, sy, ct, st] = [Math.cos(view.yaw), Math.sin(view.yaw), Math.cos(view.tilt), Math.sin(view.tilt)];
    const [up, side, ahead] = base(view.up);
    const back = [0, 1, 2].map((k) => ct * (cy * side[k] + sy * ahead[k]) + st * up[k]);
    const right = unit(cross(up, back));
    const top = cross(back, right);
    const far = view.size * 4;
    const eye = [0, 1, 2].map((k) => view.centre[k] + far * back[k]);
    const [near, end] = [far - 2 * view.size, far + 2 * view.size];
    const zoom = (far / (0.5 * view.size)) * view.zoom * Math.min(1, width / high);
    const across = zoom * (high / width);
    const a = -(end + near) / (end - near), b = (-2 * end * near) / (end - near);
    const rows = [right.map((v) => v * across), top.map((v) => v * zoom), back.map((v) => v * a), back.map((v) => -v)];
    const shift = [-across * dot(right, eye), -zoom * dot(top, eye), b - a * dot(back, eye), dot(back, eye)];
    const matrix = new Float32Array(16);
    rows.forEach((row, i) => { row.forEach((v, k) => (matrix[4 * k + i] = v)); matrix[12 + i] = shift[i]; });
    return { matrix, back, right, top };
  }
  const light = ({ back, right, top }) => unit([0, 1, 2].map((k) => back[k] - 0.45 * right[k] + 0.55 * top[k]));
  const rgb = (text) => [1, 3, 5].map((k) => parseInt(text.slice(k, k + 2), 16) / 255);

  // A surface of points with triangles; `shades` gives each point a colour of its own, red, green and blue of 255.
  view.mesh = (points, triangles, shades) => {
    const mesh = { points, triangles, shades, count: triangles.length };
    if (!gl) return mesh;
    const buffer = (kind, data) => {
      const made = gl.createBuffer();
      gl.bindBuffer(kind, made);
      gl.bufferData(kind, data, gl.STATIC_DRAW);
      return made;
    };
    mesh.array = gl.createVertexArray();
    gl.bindVertexArray(mesh.array);
    mesh.buffers = [buffer(gl.ARRAY_BUFFER, Float32Array.from(points))];
    gl.enableVertexAttribArray(0);
    gl.vertexAttribPointer(0, 3, gl.FLOAT, false, 0, 0);
    if (shades) {
      mesh.buffers.push(buffer(gl.ARRAY_BUFFER, Uint8Array.from(shades)));
      gl.enableVertexAttribArray(1);
      gl.vertexAttribPointer(1, 3, gl.UNSIGNED_BYTE, true, 0, 0);
    }
    mesh.buffers.push(buffer(gl.ELEMENT_ARRAY_BUFFER, Uint32Array.from(triangles)));
    gl.bindVertexArray(null);
    return mesh;
  };
  view.free = (mesh) => { if (gl && mesh) { mesh.buffers.forEach((b) => gl.deleteBuffer(b)); gl.deleteVertexArray(mesh.array); } };

  const VERTEX = `#version 300 es
layout(location = 0) in vec3 place;
layout(location = 1) in vec3 shade;
uniform mat4 camera; uniform mat3 turn; uniform vec3 centre; uniform float from; uniform float pitch;
out vec3 world; out vec3 own;
void main() {
  float a = from + pitch * float(gl_InstanceID);
  float c = cos(a), s = sin(a);
  world = turn * vec3(c * place.x - s * place.y, s * place.x + c * place.y, place.z) + centre;
  own = shade;
  gl_Position = camera * vec4(world, 1.0);
}`;
  const FRAGMENT = `#version 300 es
precision highp float;
in vec3 world; in vec3 own;
uniform vec4 ink; uniform vec3 light; uniform bool shaded; uniform bool flat_ink;
out vec4 paint;
void main() {
  vec3 normal = normalize(cross(dFdx(world), dFdy(world)));
  float lit = flat_ink ? 1.0 : 0.35 + 0.65 * abs(dot(normal, light));
  paint = vec4((shaded ? own : ink.rgb) * lit, ink.a);
}`;
  let places = null;
  function program() {
    const part = (kind, text) => {
      const made = gl.createShader(kind);
      gl.shaderSource(made, text);
      gl.compileShader(made);
      return made;
    };
    const made = gl.createProgram();
    gl.attachShader(made, part(gl.VERTEX_SHADER, VERTEX));
    gl.attachShader(made, part(gl.FRAGMENT_SHADER, FRAGMENT));
    gl.linkProgram(made);
    if (!gl.getProgramParameter(made, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(made));
    gl.useProgram(made);
    return Object.fromEntries(["camera", "turn", "centre", "from", "pitch", "ink", "light", "shaded", "flat_ink"].map((name) => [name, gl.getUniformLocation(made, name)]));
  }

  // Draws items: a mesh with `turn` (nine numbers, columns), `centre`, the angle `from` of the first of `count` copies a `pitch` apart, ink and opacity; `unlit` for marks.
  view.items = [];
  view.draw = (items) => {
    view.items = items;
    const width = Math.max(host.clientWidth, 200), high = height(width);
    const scale = Math.min(devicePixelRatio, 2);
    const pixels = [width, high].map((v) => Math.round(v * scale));
    if (canvas.width !== pixels[0] || canvas.height !== pixels[1]) {
      [canvas.width, canvas.height] = pixels;
      canvas.style.cssText = `width: ${width}px; height: ${high}px`;
    }
    const seen = camera(width, high);
    const sorted = [...items].sort((a, b) => (b.opacity ?? 1) - (a.opacity ?? 1));
    if (!gl) return paint(canvas.getContext("2d"), sorted, seen, pixels);
    places ??= program();
    gl.viewport(0, 0, ...pixels);
    gl.clearColor(...rgb(G.colour("--paper")), 1);
    gl.enable(gl.DEPTH_TEST);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
    gl.depthMask(true);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.uniformMatrix4fv(places.camera, false, seen.matrix);
    gl.uniform3fv(places.light, light(seen));
    for (const item of sorted) {
      const opacity = item.opacity ?? 1;
      const one = (of) => {
        gl.uniformMatrix3fv(places.turn, false, Float32Array.from(item.turn));
        gl.uniform3fv(places.centre, item.centre);
        gl.uniform1f(places.from, item.from ?? 0);
        gl.uniform1f(places.pitch, item.pitch ?? 0);
        gl.uniform4f(places.ink, ...rgb(item.ink ?? "#888888"), of);
        gl.uniform1i(places.shaded, item.mesh.shades ? 1 : 0);
        gl.uniform1i(places.flat_ink, item.unlit ? 1 : 0);
        gl.bindVertexArray(item.mesh.array);
        gl.drawElementsInstanced(gl.TRIANGLES, item.mesh.count, gl.UNSIGNED_INT, 0, item.count ?? 1);
      };
      if (opacity < 1) {
        // The nearest surface alone: its depth first, then its colour.
        gl.colorMask(false, false, false, false);
        one(1);
        gl.colorMask(true, true, true, true);
        gl.depthFunc(gl.LEQUAL);
        one(opacity);
        gl.depthFunc(gl.LESS);
      } else one(1);
    }
    gl.bindVertexArray(null);
  };

  // Without WebGL: triangles from back to front.
  function paint(ctx, items, seen, [width, high]) {
    ctx.clearRect(0, 0, width, high);
    const lit = light(seen), m = seen.matrix, all = [];
    for (const item of items) for (let copy = 0; copy < (item.count ?? 1); copy++) {
      const a = (item.from ?? 0) + copy * (item.pitch ?? 0), c = Math.cos(a), s = Math.sin(a), { points, triangles, shades } = item.mesh;
      const world = [];
      for (let i = 0; i < points.length; i += 3) {
        const own = [c * points[i] - s * points[i + 1], s * points[i] + c * points[i + 1], points[i + 2]];
        world.push([0, 1, 2].map((k) => item.turn[k] * own[0] + item.turn[3 + k] * own[1] + item.turn[6 + k] * own[2] + item.centre[k]));
      }
      const flat = world.map((p) => [0, 1, 3].map((i) => m[i] * p[0] + m[4 + i] * p[1] + m[8 + i] * p[2] + m[12 + i]));
      for (let i = 0; i < triangles.length; i += 3) {
        const t = [triangles[i], triangles[i + 1], triangles[i + 2]];
        const [p, q, r] = t.map((j) => world[j]);
        const normal = cross([0, 1, 2].map((k) => q[k] - p[k]), [0, 1, 2].map((k) => r[k] - p[k]));
        const share = item.unlit ? 1 : 0.35 + 0.65 * Math.abs(dot(unit(normal), lit));
        const own = shades ? [0, 1, 2].map((k) => shades[3 * t[0] + k] / 255) : rgb(item.ink ?? "#888888");
        const depth = flat[t[0]][2] + flat[t[1]][2] + flat[t[2]][2];
        if (Number.isFinite(share)) all.push({ depth, at: t.map((j) => flat[j]), paint: `rgb(${own.map((v) => Math.round(255 * v * share)).join(",")})`, opacity: item.opacity ?? 1 });
      }
    }
    all.sort((a, b) => b.depth - a.depth);
    for (const { at, paint, opacity } of all) {
      ctx.beginPath();
      at.forEach(([x, y, w], k) => ctx[k ? "lineTo" : "moveTo"](width * (0.5 + (0.5 * x) / w), high * (0.5 - (0.5 * y) / w)));
      ctx.closePath();
      ctx.globalAlpha = opacity;
      ctx.fillStyle = ctx.strokeStyle = paint;
      ctx.fill();
      ctx.stroke();
    }
    ctx.globalAlpha = 1;
  }

  // The camera by mouse, touch and keys; a finger turns once the picture has the focus, else the page scrolls.
  const redraw = () => view.draw(view.items);
  // Print takes the frame of WebGL that was shown last, in the colours of the screen: a copy of the light one is printed in its place.
  addEventListener("beforeprint", () => {
    const copy = Object.assign(G.element("canvas"), { className: "printed", width: canvas.width, height: canvas.height });
    copy.getContext("2d").drawImage(canvas, 0, 0);
    canvas.before(copy);
    addEventListener("afterprint", () => copy.remove(), { once: true });
  });
  const turn = (yaw, tilt) => {
    view.yaw += yaw;
    view.tilt = Math.min(Math.max(view.tilt + tilt, -1.5), 1.5);
    redraw();
  };
  const scale = (by) => { view.zoom = Math.min(Math.max(view.zoom * by, 0.3), 30); redraw(); };
  const held = new Map();
  canvas.addEventListener("pointerdown", (event) => {
    held.set(event.pointerId, [event.clientX, event.clientY]);
    canvas.setPointerCapture(event.pointerId);
  });
  canvas.addEventListener("pointermove", (event) => {
    if (!held.has(event.pointerId)) return;
    const before = [...held.values()];
    const [x, y] = held.get(event.pointerId);
    held.set(event.pointerId, [event.clientX, event.clientY]);
    if (held.size === 1) return turn(-0.008 * (event.clientX - x), 0.008 * (event.clientY - y));
    const apart = ([a, b]) => Math.hypot(a[0] - b[0], a[1] - b[1]);
    const after = [...held.values()];
    if (apart(before) > 0) scale(apart(after) / apart(before));
  });
  for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, (event) => held.delete(event.pointerId));
  canvas.addEventListener("wheel", (event) => {
    if (document.activeElement !== canvas) return;
    event.preventDefault();
    scale(event.deltaY < 0 ? 1.15 : 1 / 1.15);
  }, { passive: false });
  canvas.addEventListener("keydown", (event) => {
    const act = {
      ArrowLeft: () => turn(0.12, 0), ArrowRight: () => turn(-0.12, 0), ArrowUp: () => turn(0, -0.12), ArrowDown: () => turn(0, 0.12),
      "+": () => scale(1.2), "-": () => scale(1 / 1.2), 0: () => { Object.assign(view, home); redraw(); },
    }[event.key];
    if (act) { event.preventDefault(); act(); }
  });
  G.spaces.push(view);
  return view;
};
G.spaces = [];
G.vectors = {
  cross: (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]],
  dot: (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2],
  unit: (a) => a.map((v) => v / (Math.hypot(...a) || 1)),
};
// A place between the corners of a flank, toe root, heel root, heel tip, toe tip, by its shares of face and height.
G.onCorners = ([tr, hr, ht, tt], f, h) => [0, 1].map((n) => (1 - h) * ((1 - f) * tr[n] + f * hr[n]) + h * ((1 - f) * tt[n] + f * ht[n]));

// Triangles of a grid of points, ring by ring.
G.gridTriangles = (rings, around) => {
  const all = [];
  for (let i = 0; i + 1 < rings; i++) for (let k = 0; k + 1 < around; k++) {
    const [a, b, c, d] = [i * around + k, i * around + k + 1, (i + 1) * around + k + 1, (i + 1) * around + k];
    all.push(a, b, c, a, c, d);
  }
  return all;
};
