"use strict";
// Deviations over a flank as a surface in space, by height and colour; a row of the table chooses the flank.
G.kind("surface", (data, host) => {
  const { surfaces } = data;
  const box = G.element("div", undefined, "view");
  const [side, main] = [G.element("div", undefined, "side"), G.element("div", undefined, "main turning")];
  box.append(side, main);
  host.append(box);
  const key = G.element("div", undefined, "scale");
  const caption = G.element("p", "", "note");
  const SHARE = 0.22; // height of the range of a surface, in lengths of its face
  let [shape, chosen] = [null, null];
  const home = { yaw: 0.5, tilt: 0.75, zoom: 1, centre: [0, 0, 0], size: 1, up: [0, 0, 1] };
  const space = G.space(main, (width) => Math.round(Math.min(0.6 * width, 480)), home);
  main.append(key, caption);
  const number = (x) => G.number(Math.abs(x) < 1e-6 ? 0 : Number(x.toPrecision(3)));

  function choose(k) {
    const s = (chosen = surfaces[k]);
    space.free(shape);
    const xs = s.corners_m.map((p) => p[0]), ys = s.corners_m.map((p) => p[1]);
    const [length, high] = [Math.max(...xs) - Math.min(...xs), Math.max(...ys) - Math.min(...ys)];
    const range = Math.max(s.highest_um - s.lowest_um, 1e-9);
    // Drawn with the face as the unit; the height of the tooth is stretched where it is much less.
    const up = Math.max(1, (0.45 * length) / high);
    const [points, shades, whole] = [[], [], []];
    for (let i = 0; i < s.rows; i++) for (let j = 0; j < s.columns; j++) {
      const [h, f] = [i / (s.rows - 1), j / (s.columns - 1)];
      const p = G.onCorners(s.corners_m, f, h);
      // No surface where there is no value.
      const share = ((s.values_um[i * s.columns + j] ?? NaN) - s.lowest_um) / range;
      whole.push(Number.isFinite(share));
      points.push((p[0] - Math.min(...xs)) / length - 0.5, ((p[1] - Math.min(...ys)) / length) * up - (0.5 * high * up) / length, SHARE * ((Number.isFinite(share) ? share : 0) - 0.5));
      shades.push(...G.shade(Number.isFinite(share) ? share : 0));
    }
    const triangles = [];
    const all = G.gridTriangles(s.rows, s.columns);
    for (let n = 0; n < all.length; n += 3) if (whole[all[n]] && whole[all[n + 1]] && whole[all[n + 2]]) triangles.push(all[n], all[n + 1], all[n + 2]);
    shape = space.mesh(points, triangles, shades);
    key.replaceChildren(G.element("span", number(s.lowest_um) + " µm"), G.element("span", undefined, "colours"), G.element("span", number(s.highest_um) + " µm"));
    key.children[1].style.background = `linear-gradient(to right, ${Array.from({ length: 9 }, (_, n) => `rgb(${G.shade(n / 8).join(",")})`).join(", ")})`;
    const corner = (i, j) => { const v = s.values_um[i * s.columns + j]; return Number.isFinite(v) ? number(v) + " µm" : "none"; };
    const [top, end] = [s.rows - 1, s.columns - 1];
    const exaggerated = Math.round((SHARE * length * 1e6) / range);
    caption.textContent = `${s.names.join(", ")}: ${data.quantity}. Drawn ${G.number(exaggerated, 2)} times larger than the face${up > 1 ? `, the tooth ${number(up)} times higher` : ""}. Root at toe ${corner(0, 0)}, root at heel ${corner(0, end)}, tip at toe ${corner(top, 0)}, tip at heel ${corner(top, end)}. At first the toe is left and the root in front.`;
    space.canvas.setAttribute("aria-label", caption.textContent + " Arrow keys turn the view.");
    show();
  }
  const show = () => shape && space.draw([{ mesh: shape, turn: [1, 0, 0, 0, 1, 0, 0, 0, 1], centre: [0, 0, 0] }]);
  G.redraws.push(show);
  const rows = surfaces.map((s) => [...s.names, number(s.lowest_um), number(s.highest_um)]);
  if (surfaces.length > 1) G.chooser(side, [...data.heads, "lowest µm", "highest µm"], rows, 0, choose);
  else { side.remove(); box.classList.remove("view"); choose(0); }
});
