"use strict";
// A table of modes next to a picture that moves by the chosen one: `height` of the picture by its width, CSS pixels; `draw` takes the phase.
G.modeView = (host, modes, height, draw) => {
  const [box, side, stage] = ["view", "side", "moving"].map((name) => G.element("div", undefined, name));
  const caption = G.element("p", "", "note");
  box.append(side, stage);
  host.append(box);
  const picture = G.canvas(stage, height);
  picture.canvas.setAttribute("role", "img");
  stage.append(caption);
  const player = G.player(box, draw, 2);
  side.before(player.button);
  const columns = [["mode", (m) => String(m.mode)], ["Hz", (m) => (m.frequency_hz === null ? "–" : G.number(m.frequency_hz))]];
  if (modes.some((m) => m.damping_ratio !== null)) columns.push(["ζ/%", (m) => (m.damping_ratio === null ? "–" : G.number(100 * m.damping_ratio, 3))]);
  // Shows the table; `take` makes the shape of a mode and returns its caption; `more` are further columns.
  const choose = (first, take, more = []) => {
    const all = [...columns, ...more];
    G.chooser(side, all.map((c) => c[0]), modes.map((m) => all.map((c) => c[1](m))), first, (k) => {
      caption.textContent = take(k);
      picture.canvas.setAttribute("aria-label", caption.textContent);
      player.phase = 0;
      player.show();
    });
    host.querySelector(".chooser").view = player;
  };
  return { ...picture, player, choose };
};
