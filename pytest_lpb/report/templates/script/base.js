// What all parts share: elements, packed data, numbers, colours.
const all = (selector, root = document) => [...root.querySelectorAll(selector)];
const SVG = "http://www.w3.org/2000/svg";

// Children are elements or text; text never becomes markup.
function build(node, attributes, children) {
  for (const [name, value] of Object.entries(attributes)) {
    if (value !== null && value !== undefined && value !== false) node.setAttribute(name, value === true ? "" : value);
  }
  node.append(...children.flat().filter((child) => child !== null && child !== undefined && child !== ""));
  return node;
}
// 1 pair, 3 pairs.
const counted = (number, noun) => `${number} ${noun}${number === 1 ? "" : "s"}`;
const el = (tag, attributes = {}, ...children) => build(document.createElement(tag), attributes, children);
const svg = (tag, attributes = {}, ...children) => build(document.createElementNS(SVG, tag), attributes, children);

const blocks = new Map(all("script[data-block]").map((node) => [node.dataset.block, node]));
const opened = new Map();

async function inflate(text) {
  const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return JSON.parse(await new Response(stream).text());
}

// The data of a block, read once; undefined when the report has none of this name.
function unpack(key) {
  if (!opened.has(key)) opened.set(key, blocks.has(key) ? inflate(blocks.get(key).textContent) : Promise.resolve());
  return opened.get(key);
}

// Columns of numbers from running sums; NaN where there is none.
function columns(list) {
  const found = [];
  for (let begin = 0; begin < list.d.length; begin += list.n) {
    const column = new Float64Array(list.n);
    let sum = 0;
    for (let row = 0; row < list.n; row += 1) {
      const change = list.d[begin + row];
      if (change !== null) sum += change;
      column[row] = change === null ? NaN : sum * list.s;
    }
    found.push(column);
  }
  return found;
}

const outcomeClass = (name) => "o-" + name.replaceAll("_", "-");
const words = (name) => name.replaceAll("_", " ");
const trialLink = (id, params = "") => "#/trial/" + encodeURIComponent(id) + params;

function swatch(style) {
  return svg("svg", { class: `swatch p${style.colour}`, width: 30, height: 14, "aria-hidden": "true" },
    svg("use", { href: "#planner" + style.number }));
}
const planner = (style) => el("span", { class: "planner" }, swatch(style), el("span", {}, style.name));
// How a trial ended, as [.., outcome, .., .., reason of a known failure].
const chip = (trial, href) => el(href ? "a" : "span", { class: `chip ${outcomeClass(trial[4])}${trial[7] ? " known" : ""}`, href, title: trial[7] ? "known failure: " + trial[7] : null },
  words(trial[4]), trial[7] ? " · known" : "");

// Round numbers between low and high, about `most` of them.
function ticks(low, high, most) {
  const rough = (high - low) / Math.max(most - 1, 1);
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((factor) => factor * power).find((size) => size >= rough * 0.999);
  const decimals = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  const found = [];
  for (let number = Math.ceil(low / step - 1e-9); number * step <= high + step * 1e-9; number += 1) {
    const value = number * step, size = Math.max(Math.abs(low), Math.abs(high));
    const digits = number === 0 ? 0 : Math.max(0, Math.floor(Math.log10(Math.abs(value)) + 1e-9) - Math.floor(Math.log10(step) + 1e-9));
    const text = number === 0 ? "0" : value.toExponential(digits).replace("e+", "e");
    found.push([value, (size < 1e-3 || size >= 1e6 ? text : value.toFixed(Math.min(decimals, 8)).replace(/^-(0(\.0*)?)$/, "$1")).replaceAll("-", "−")]);
  }
  return found;
}

// Three significant digits, fewer where a value is known in steps only, with a true minus sign.
function figure(value, step = 0) {
  if (!Number.isFinite(value)) return "–";
  if (Math.abs(value) < step / 2) return "0";
  const size = Math.abs(Number(value.toPrecision(3)));
  if (size !== 0 && (size < 1e-3 || size >= 1e6)) return value.toExponential(1).replaceAll("-", "−");
  const decimals = size === 0 ? 0 : Math.max(0, 2 - Math.floor(Math.log10(size)));
  const kept = step > 0 ? Math.max(0, Math.ceil(-Math.log10(2 * step))) : 6;
  return value.toFixed(Math.min(decimals, kept, 6)).replace(/^-(0(\.0*)?)$/, "$1").replace("-", "−");
}

// A CSS variable as [red, green, blue].
function colour(name) {
  const text = getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  return [1, 3, 5].map((place) => parseInt(text.slice(place, place + 2), 16));
}
const css = (rgb, opacity = 1) => `rgb(${rgb[0]} ${rgb[1]} ${rgb[2]} / ${opacity})`;
const mixed = (a, b, share) => a.map((value, place) => value * (1 - share) + b[place] * share);

// The address: #/view/rest?parameters.
const address = {
  read() {
    const [path, query = ""] = location.hash.replace(/^#\/?/, "").split("?");
    const slash = path.indexOf("/");
    const rest = slash < 0 ? "" : path.slice(slash + 1);
    let name = rest;
    try { name = decodeURIComponent(rest); } catch { /* typed by hand: taken as it is */ }
    return { view: slash < 0 ? path : path.slice(0, slash), path, rest: name, params: new URLSearchParams(query) };
  },
  // Changes parameters without a new step in the history.
  write(changes) {
    const { path, params } = address.read();
    for (const [key, value] of Object.entries(changes)) {
      if (value) params.set(key, value); else params.delete(key);
    }
    const query = params.toString();
    history.replaceState(history.state, "", "#/" + path + (query ? "?" + query : ""));
  },
};
// View -> what shows it: (rest of the path, parameters) => title, or nothing for the view's own.
const views = {};
