// Elements, colours and numbers of a page: first of the scripts that share one scope, base, columns, marks, plot, page.
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
