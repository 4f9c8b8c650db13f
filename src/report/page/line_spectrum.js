"use strict";
// The amplitude spectrum of the curves of a time plot over the range shown: evenly interpolated, without mean, Hann window, amplitudes of sines.
G.amplitudes = (x, y, [from, to]) => {
  const [first, last] = [G.search(x, from), Math.min(G.search(x, to), x.length - 1)];
  const LEAST = 32, MOST = 1 << 20;
  if (last - first < LEAST) return null;
  let count = LEAST;
  while (count < last - first && count < MOST) count *= 2;
  const time = x[last] - x[first], re = new Float64Array(count), im = new Float64Array(count);
  let mean = 0, j = first;
  for (let i = 0; i < count; i++) {
    const t = x[first] + (time * i) / count;
    while (j + 1 < last && x[j + 1] <= t) j++;
    re[i] = y[j] + ((y[j + 1] - y[j]) * (t - x[j])) / (x[j + 1] - x[j] || 1);
    mean += re[i] / count;
  }
  for (let i = 0; i < count; i++) re[i] = (re[i] - mean) * (0.5 - 0.5 * Math.cos((2 * Math.PI * i) / count));
  // Radix 2 after Cooley and Tukey (1965): reversed order, then halves.
  for (let i = 1, k = 0; i < count; i++) {
    let bit = count >> 1;
    for (; k & bit; bit >>= 1) k ^= bit;
    k ^= bit;
    if (i < k) [re[i], re[k]] = [re[k], re[i]];
  }
  for (let size = 2; size <= count; size *= 2) {
    const half = size / 2;
    for (let k = 0; k < half; k++) {
      const [c, s] = [Math.cos((2 * Math.PI * k) / size), -Math.sin((2 * Math.PI * k) / size)];
      for (let i = k; i < count; i += size) {
        const n = i + half, a = re[n] * c - im[n] * s, b = re[n] * s + im[n] * c;
        [re[n], im[n]] = [re[i] - a, im[i] - b];
        [re[i], im[i]] = [re[i] + a, im[i] + b];
      }
    }
  }
  // Lines up to half the rate of the points.
  const lines = Math.min(count / 2, (last - first) >> 1);
  const at = Float64Array.from({ length: lines }, (_, k) => (k + 1) / time);
  return { x: at, y: at.map((_, k) => (4 * Math.hypot(re[k + 1], im[k + 1])) / count) };
};

// A button that shows the spectrum below its plot; it follows the zoom.
G.spectrumButton = (plot, host) => {
  let box = null;
  const clear = () => { const k = G.plots.findIndex((p) => p.host === box); if (k >= 0) G.plots.splice(k, 1); box?.remove(); };
  const draw = () => {
    clear();
    box = G.element("div", undefined, "plot");
    host.after(box);
    const curves = plot.curves.filter((c) => c.rising && c.mark === "line").flatMap((c) => {
      const found = G.amplitudes(c.x, c.y, plot.shown.x);
      return found ? [{ ...c, ...found, size: 1, low: [], high: [], radii: [] }] : [];
    });
    const axis = { log: false, range: null, unit: null, ticks: [], factor: 1 };
    const above = { guides: [], bands: [], labels: [], map: null, at_end: false, equal: false };
    const unit = plot.y.label.split(", ").at(-1);
    G.makePlot({ ...above, curves, events: [], x: { ...axis, label: "frequency, Hz" }, y: { ...axis, log: true, label: `amplitude, ${unit}`, factor: plot.y.factor }, height: 200, heading: `spectrum of ${plot.heading || plot.y.label}`, empty: "too few points are shown for a spectrum" }, box, null, plot.name + ".spectrum", true);
  };
  const button = G.button("spectrum", () => {
    const on = button.ariaPressed === "false";
    button.ariaPressed = String(on);
    plot.follow = on ? draw : undefined;
    on ? draw() : clear();
  });
  button.ariaPressed = "false";
  return button;
};
