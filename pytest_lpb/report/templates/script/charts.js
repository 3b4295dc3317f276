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

const known = (value) => value !== null && value !== undefined;
const limitsOf = (lines) => [...new Set(lines.flatMap((line) => line.limits || []).filter(known))];

function yRange(chart, lines) {
  const values = lines.flatMap((line) => extent(line.v)).concat(chart.limit ?? []);
  let [low, high] = extent(values);
  // Limits far away must not make the lines flat.
  const reach = 1.5 * Math.max(high - low, 0.2 * Math.max(Math.abs(low), Math.abs(high)));
  [low, high] = extent([low, high, ...limitsOf(lines).filter((limit) => limit > low - reach && limit < high + reach)]);
  if (low > 0 && low < 0.5 * high) low = 0;
  const room = 0.05 * (high - low) || 0.1 * Math.abs(high) || 1;
  return [low === 0 ? 0 : low - room, high + room];
}

const DRAW = {
  line: (places) => "M" + places.map(([x, y]) => `${x.toFixed(1)} ${y.toFixed(1)}`).join("L"),
  step: (places) => "M" + places.map(([x, y], row) => (row ? `H${x.toFixed(1)}V` : `${x.toFixed(1)} `) + y.toFixed(1)).join(""),
  dots: (places) => places.map(([x, y]) => `M${x.toFixed(1)} ${y.toFixed(1)}h0`).join(""),
};

// Of a single trial, lines have colours of their own; of two, the planners' (which nothing else has), and dashes.
const hueOf = (line, alone) => (alone && line.of > 1 ? "s" + line.number % 8 : "p" + line.style.colour);

function curve(line, place, alone) {
  const points = Array.from(line.t, (t, row) => place(t, line.v[row]));
  const dash = line.kind === "dots" || (alone && line.number < 8) ? "" : line.of > 1 ? DASHES[(alone ? line.number >> 3 : line.number) % 5] : line.style.dash;
  return svg("path", { class: `${line.kind === "dots" ? "dots" : "path"} ${hueOf(line, alone)}`, "data-line": line.name, d: DRAW[line.kind](points), "stroke-dasharray": dash || null });
}

// Dotted lines at the limits of each line, in its colour; those that lines share in ink.
function limitLines(lines, place, low, high, alone) {
  const owners = new Map();
  for (const line of lines) for (const limit of (line.limits || []).filter(known)) owners.set(limit, [...(owners.get(limit) || []), line]);
  return [...owners].filter(([limit]) => limit >= low && limit <= high).map(([limit, own]) => {
    const shared = !alone || own.length > 1 || own[0].of === 1;
    return svg("path", { class: "limit " + (shared ? "" : hueOf(own[0], alone)), "data-line": shared ? null : own[0].name, d: `M0 ${place(0, limit)[1]}H1000` });
  });
}
const limitText = ({ limits }) => (limits ? `limits ${known(limits[0]) ? figure(limits[0]) : "−∞"} to ${known(limits[1]) ? figure(limits[1]) : "∞"}` : "");

// What stands beside the title: the tolerance, or which limits there are.
function limitNote(chart, lines, low, high) {
  const label = (text) => el("small", {}, el("i", { class: "limit-key" }), " " + text);
  if (chart.limit !== null) return label(chart.limitLabel);
  const limits = limitsOf(lines), texts = new Set(lines.map(limitText));
  if (!limits.length) return "";
  const text = texts.size === 1 ? [...texts][0] : "limits";
  return limits.some((limit) => limit >= low && limit <= high) ? label(text) : el("small", {}, text === "limits" ? "limits are farther away" : text);
}

// A line's value at a time: between its points as it is drawn, none after its end.
function valueAt(line, t) {
  if (t > line.t.at(-1) + 1e-9 && line.kind === "line") return NaN;
  if (line.kind === "line") return blended(line.v, between(line.t, t));
  return line.v[Math.max(line.t.findLastIndex((time) => time <= t + 1e-9), 0)];
}

function chartFigure(chart, tracks, end, seek) {
  const lines = tracks.flatMap((track) => (track.charts.find((other) => other.title === chart.title)?.lines || [])
    .map((line, number, every) => ({ ...line, number, of: every.length, style: track.style })));
  const alone = tracks.length === 1;
  const [low, high] = yRange(chart, lines);
  const place = (t, value) => [1000 * t / end, 1000 * (high - value) / (high - low)];
  const xTicks = ticks(0, end, 7), yTicks = ticks(low, high, 5);
  const picture = svg("svg", { viewBox: "0 0 1000 1000", preserveAspectRatio: "none", role: "img", "aria-label": chart.title + " over time" },
    xTicks.map(([t]) => path("grid", `M${1000 * t / end} 0V1000`)),
    yTicks.map(([value]) => path("grid", `M0 ${place(0, value)[1]}H1000`)),
    chart.limit === null ? null : path("limit", `M0 ${place(0, chart.limit)[1]}H1000`),
    limitLines(lines, place, low, high, alone),
    tracks.map((track) => (known(track.contact) ? svg("path", { class: "contact", d: `M${1000 * track.contact / end} 0V1000` }, svg("title", {}, "contact")) : null)),
    lines.map((line) => curve(line, place, alone)));
  const cursor = path("cursor", "M0 0V1000");
  picture.append(cursor);
  const now = el("output", { class: "now" });
  const at = (event) => {
    const box = picture.getBoundingClientRect();
    seek(Math.min(Math.max((event.clientX - box.left) / box.width, 0), 1) * end);
  };
  picture.addEventListener("pointerdown", (event) => { picture.setPointerCapture(event.pointerId); at(event); });
  picture.addEventListener("pointermove", (event) => { if (event.buttons) at(event); });
  const [legend, tell] = legendOf(lines, picture, alone);
  const node = el("figure", {},
    el("figcaption", {}, chart.title, " ", now, limitNote(chart, lines, low, high)), legend,
    el("div", { class: "timeline" },
      el("div", { class: "y-axis", "aria-hidden": "true" }, yTicks.map(([value, text]) => el("span", { style: `top:${place(0, value)[1] / 10}%` }, text))),
      picture,
      el("div", { class: "axis", "aria-hidden": "true" }, xTicks.map(([t, text]) => el("span", { style: `left:${100 * t / end}%` }, text)))));
  const show = (t) => {
    cursor.setAttribute("d", `M${1000 * Math.min(t / end, 1)} 0V1000`);
    now.textContent = lines.every((line) => line.of === 1) ? lines.map((line) => figure(valueAt(line, t), line.step)).join(" · ") : "";
    tell(t);
  };
  return { node, show, below: chart.below };
}

// Names of lines with their values; a click leaves only the one in colour. And what tells the values.
function legendOf(lines, picture, alone) {
  const keyed = lines.filter((line) => line.of > 1);
  const names = [...new Set(keyed.map((line) => line.name))];
  if (!names.length) return ["", () => {}];
  let chosen = "";
  const keys = names.map((name) => {
    const own = keyed.filter((line) => line.name === name);
    const value = el("output", {});
    const dash = DASHES[(alone ? own[0].number >> 3 : own[0].number) % 5];
    const sample = svg("svg", { class: "swatch " + (alone ? hueOf(own[0], alone) : ""), width: alone ? 18 : 30, height: 14, "aria-hidden": "true" },
      svg("path", { class: "path", d: `M0 7H${alone ? 18 : 30}`, "stroke-dasharray": dash || null }));
    const button = el("button", { type: "button", "aria-pressed": "false", title: limitText(own[0]) || null }, sample, name);
    button.addEventListener("click", () => { chosen = chosen === name ? "" : name; mark(); });
    return { name, own, value, button };
  });
  const mark = () => {
    keys.forEach(({ name, button }) => button.setAttribute("aria-pressed", String(name === chosen)));
    all("[data-line]", picture).forEach((node) => node.classList.toggle("faint", chosen !== "" && node.dataset.line !== chosen));
  };
  const legend = el("span", { class: "legend" }, keys.map(({ button, value }) => el("span", {}, button, value)));
  return [legend, (t) => keys.forEach(({ own, value }) => { value.textContent = own.map((line) => figure(valueAt(line, t), line.step)).join(" · "); })];
}
