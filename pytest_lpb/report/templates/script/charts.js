// Time series of one or two trials on one axis, with a line at the time that the replay shows.
const DASHES = ["", "7 3", "2 3", "8 3 2 3", "12 4 2 4 2 4"];

function extent(values) {
  let low = Infinity, high = -Infinity;
  for (const value of values) {
    if (value < low) low = value;
    if (value > high) high = value;
  }
  return [low, high];
}

function yRange(chart, lines) {
  const values = lines.flatMap((line) => extent(line.v)).concat(chart.limit ?? []);
  let [low, high] = extent(values);
  if (low > 0 && low < 0.5 * high) low = 0;
  const room = 0.05 * (high - low) || 0.1 * Math.abs(high) || 1;
  return [low === 0 ? 0 : low - room, high + room];
}

const DRAW = {
  line: (places) => "M" + places.map(([x, y]) => `${x.toFixed(1)} ${y.toFixed(1)}`).join("L"),
  step: (places) => "M" + places.map(([x, y], row) => (row ? `H${x.toFixed(1)}V` : `${x.toFixed(1)} `) + y.toFixed(1)).join(""),
  dots: (places) => places.map(([x, y]) => `M${x.toFixed(1)} ${y.toFixed(1)}h0`).join(""),
};

// One curve: colour by its own number where a single trial is shown, by the planner where there are two.
function curve(chart, line, place, alone) {
  const points = Array.from(line.t, (t, row) => place(t, line.v[row]));
  const hue = alone && line.of > 1 ? line.number % 8 : line.style.colour;
  const dash = chart.kind === "dots" || alone ? "" : line.of > 1 ? DASHES[line.number % 5] : line.style.dash;
  return svg("path", { class: `${chart.kind === "dots" ? "dots" : "path"} p${hue}`, d: DRAW[chart.kind](points), "stroke-dasharray": dash || null });
}

function valueAt(line, t) {
  let row = 0;
  while (row + 1 < line.t.length && line.t[row + 1] <= t + 1e-9) row += 1;
  return line.v[row];
}

function chartFigure(chart, tracks, end, seek) {
  const lines = tracks.flatMap((track) => (track.charts.find((other) => other.title === chart.title)?.lines || [])
    .map((line, number, every) => ({ ...line, number, of: every.length, style: track.style })));
  const [low, high] = yRange(chart, lines);
  const place = (t, value) => [1000 * t / end, 1000 * (high - value) / (high - low)];
  const xTicks = ticks(0, end, 7), yTicks = ticks(low, high, 5);
  const picture = svg("svg", { viewBox: "0 0 1000 1000", preserveAspectRatio: "none", role: "img", "aria-label": chart.title + " over time" },
    xTicks.map(([t]) => path("grid", `M${1000 * t / end} 0V1000`)),
    yTicks.map(([value]) => path("grid", `M0 ${place(0, value)[1]}H1000`)),
    chart.limit === null ? null : path("limit", `M0 ${place(0, chart.limit)[1]}H1000`),
    lines.map((line) => curve(chart, line, place, tracks.length === 1)));
  const cursor = path("cursor", "M0 0V1000");
  picture.append(cursor);
  const now = el("output", { class: "now" });
  const at = (event) => {
    const box = picture.getBoundingClientRect();
    seek(Math.min(Math.max((event.clientX - box.left) / box.width, 0), 1) * end);
  };
  picture.addEventListener("pointerdown", (event) => { picture.setPointerCapture(event.pointerId); at(event); });
  picture.addEventListener("pointermove", (event) => { if (event.buttons) at(event); });
  // Lines of one trial differ in colour; of two trials in their dash, as colours are the planners'.
  const keyed = lines.filter((line) => line.of > 1 && line.style === lines.find((other) => other.of > 1).style);
  const key = (line) => (tracks.length === 1 ? el("span", { class: "p" + line.number % 8 }, line.name)
    : el("span", {}, svg("svg", { class: "swatch", width: 30, height: 14, "aria-hidden": "true" },
      svg("path", { class: "path", d: "M0 7H30", "stroke-dasharray": DASHES[line.number % 5] || null })), line.name));
  const legend = keyed.length ? el("span", { class: "legend" }, keyed.map(key)) : "";
  const node = el("figure", {},
    el("figcaption", {}, chart.title, " ", now, chart.limit === null ? "" : el("small", {}, el("i", { class: "limit-key" }), " " + chart.limitLabel)), legend,
    el("div", { class: "timeline" },
      el("div", { class: "y-axis", "aria-hidden": "true" }, yTicks.map(([value, text]) => el("span", { style: `top:${place(0, value)[1] / 10}%` }, text))),
      picture,
      el("div", { class: "axis", "aria-hidden": "true" }, xTicks.map(([t, text]) => el("span", { style: `left:${100 * t / end}%` }, text)))));
  const show = (t) => {
    cursor.setAttribute("d", `M${1000 * Math.min(t / end, 1)} 0V1000`);
    now.textContent = lines.length <= 2 ? lines.map((line) => figure(valueAt(line, t))).join(" · ") : "";
  };
  return { node, show };
}
