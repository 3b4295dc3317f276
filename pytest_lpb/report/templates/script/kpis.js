// Success bars and distributions of KPIs, of all scenarios or of one.
const kpiSelect = document.getElementById("kpi-select");
let styles = [];

const path = (name, d) => svg("path", { class: name, d });
const grid = (places) => places.map(([at]) => path("grid", `M${10 * at} 0V1000`));
const axis = (places) => el("div", { class: "row" }, el("div", { class: "name" }),
  el("div", { class: "axis", "aria-hidden": "true" }, places.map(([at, text]) => el("span", { style: `left:${at}%` }, text))),
  el("div"));

function bar(style, description, marks, ...value) {
  return el("div", { class: "row" },
    el("div", { class: "name" }, planner(style)),
    svg("svg", { class: `plot p${style.colour}`, viewBox: "0 0 1000 1000", preserveAspectRatio: "none", role: "img", "aria-label": description },
      svg("title", {}, description), marks),
    el("div", { class: "figure-value" }, ...value));
}

const QUARTERS = [0, 25, 50, 75, 100].map((at) => [at, String(at)]);

function successRow([number, rate, low, high, text]) {
  const marks = grid(QUARTERS);
  if (rate !== null) marks.push(svg("rect", { class: "bar", x: 0, y: 220, width: 10 * rate, height: 560 }));
  if (low !== null && high !== null) {
    marks.push(path("whisker", `M${10 * low} 500H${10 * high}M${10 * low} 320V680M${10 * high} 320V680`));
  }
  return bar(styles[number], `${styles[number].name}: ${text}`, marks, text);
}

function boxRow(figure, [number, points, median, box, whiskers, text, count, description]) {
  const marks = grid(figure.ticks);
  if (figure.zero !== null) marks.push(path("zero", `M${figure.zero} 0V1000`));
  if (whiskers) marks.push(path("whisker", `M${whiskers[0]} 500H${whiskers[1]}M${whiskers[0]} 350V650M${whiskers[1]} 350V650`));
  if (box) marks.push(svg("rect", { class: "bar", x: box[0], y: 200, width: box[1] - box[0], height: 600 }));
  marks.push(path("dots", points), path("median", `M${median} 140V860`));
  return bar(styles[number], description, marks, el("b", {}, text), " ", el("small", {}, "n " + count));
}

// The figure of a KPI; `scenario` leaves the other scenarios out.
async function kpiFigure(name, scenario = null) {
  const data = await unpack("kpis");
  styles = (await unpack("index")).planners;
  const own = (group) => scenario === null || group[0] === scenario;
  const head = (group) => (scenario === null ? el("h4", {}, group[0]) : null);
  const shown = data.figures[name];
  const frame = el("figure", { class: "kpi", "data-kpi": shown ? name : "success" });
  if (!shown) {
    frame.append(el("figcaption", {}, "success rate [%] ", el("small", {}, "bar: rate, each problem weighing the same, over all scenarios their mean · whisker: its 95 % interval · 17/22: trials solved")));
    for (const group of data.success.filter(own)) build(frame, {}, [head(group), group[1].map(successRow)]);
    frame.append(axis(QUARTERS));
    return frame;
  }
  const notes = [...shown.notes, "dots: trials", "box: quartiles", "bar: median"].join(" · ");
  frame.append(el("figcaption", {}, shown.title + " ", el("small", {}, notes)));
  const groups = shown.groups.filter(own);
  for (const group of groups) build(frame, {}, [head(group), group[1].map((row) => boxRow(shown, row))]);
  frame.append(groups.length ? axis(shown.ticks) : el("p", { class: "quiet" }, "No values here."));
  return frame;
}

async function showKpi(name) {
  if (![...kpiSelect.options].some((option) => option.value === name)) name = "success";
  kpiSelect.value = name;
  document.getElementById("kpi-figure").replaceChildren(await kpiFigure(name));
}

if (kpiSelect) {
  kpiSelect.addEventListener("change", () => {
    showKpi(kpiSelect.value);
    address.write({ kpi: kpiSelect.value === "success" ? "" : kpiSelect.value });
  });
  views.kpis = (rest, params) => showKpi(params.get("kpi") || "success");
}
