// The table of comparisons, and relative differences with their intervals.
const comparisonTable = document.getElementById("comparison-table");
const VERDICTS = ["better", "worse", "same", "inconclusive", ""];
const WIDEST = 200; // [%] where the axis of differences ends

function comparisonRow(data, [a, b, scenario, kpi, verdict, solved, cells], known) {
  const [name, title, , contended] = data.kpis[kpi];
  const numbers = cells.map(([text, value, note]) => el("td", { class: "num", "data-v": value }, text, note ? el("small", {}, note) : ""));
  const row = el("tr", {},
    el("td", {}, el("span", { class: `chip v-${VERDICTS[verdict]}` }, VERDICTS[verdict])),
    el("td", {}, planner(known[a])), el("td", {}, planner(known[b])), el("td", {}, data.scenarios[scenario]),
    el("td", {}, title, contended ? el("sup", {}, "†") : "", solved ? el("small", {}, "both solved") : ""), numbers);
  Object.assign(row.dataset, { a: known[a].name, b: known[b].name, scenario: data.scenarios[scenario], kpi: name, verdict: VERDICTS[verdict] });
  return row;
}

async function fillComparisons() {
  if (comparisonTable.tHead) return;
  const data = await unpack("comparisons");
  const known = (await unpack("index")).planners;
  const heads = [...["verdict", "A", "B", "scenario", "KPI"].map((text) => [text, "text"]), ...data.heads.map((text) => [text, "num"])];
  const cells = heads.map(([text, kind]) => el("th", { scope: "col", class: kind }, el("button", { type: "button" }, text)));
  if (comparisonTable.tHead) return; // filled while the data were read
  comparisonTable.append(el("thead", {}, el("tr", {}, cells)), el("tbody", {}, data.rows.map((row) => comparisonRow(data, row, known))));
  label(comparisonTable);
}

// A row of the picture: the difference and its interval if it has one, in [%] of A's figure, or in percentage points.
function forestRow(title, unit, verdict, [middle, low, high], solved, text) {
  const place = (share) => 500 + 500 * Math.sign(share) * Math.min(Math.abs(share) / WIDEST, 1) ** 0.5;
  const ends = [low, high].map(place);
  const known = low !== null && high !== null;
  const marks = [path("zero", "M500 0V1000"), known ? path("whisker", `M${ends[0]} 500H${Math.max(ends[1], ends[0] + 1)}`) : null,
    svg("rect", { class: "point", x: place(middle) - 4, y: 300, width: 8, height: 400 })];
  const told = `${figure(middle)} ${unit}` + (known ? ` (${figure(low)} to ${figure(high)})` : "");
  return el("div", { class: "row" }, el("div", { class: "name" }, title, solved ? el("small", {}, " both solved") : ""),
    svg("svg", { class: `plot v-${verdict || "none"}`, viewBox: "0 0 1000 1000", preserveAspectRatio: "none", role: "img", "aria-label": `${title}: ${told}` },
      svg("title", {}, `${title}: ${told}`), marks),
    el("div", { class: "figure-value" }, told, el("small", {}, " " + text)));
}

// The picture needs one pair of planners and one scenario.
async function showForest() {
  const data = await unpack("comparisons");
  const known = (await unpack("index")).planners;
  const chosen = Object.fromEntries(fieldsOf(comparisonTable).map((field) => [field.dataset.column, field.value]));
  const rows = data.rows.filter(([a, b, scenario]) => (!chosen.a || known[a].name === chosen.a)
    && (!chosen.b || known[b].name === chosen.b) && (!chosen.scenario || data.scenarios[scenario] === chosen.scenario));
  const frame = document.getElementById("forest");
  const pairs = new Set(rows.map(([a, b]) => `${a} ${b}`));
  if (pairs.size !== 1 || new Set(rows.map((row) => row[2])).size !== 1) {
    frame.replaceChildren(el("p", { class: "quiet" }, "Choose A, B and a scenario to see their differences as a picture."));
    return;
  }
  const [a, b] = rows[0];
  const drawn = rows.filter((row) => row[7] && (!chosen.kpi || data.kpis[row[3]][0] === chosen.kpi)
    && (!chosen.verdict || VERDICTS[row[4]] === chosen.verdict));
  const places = [-200, -50, -10, 0, 10, 50, 200].map((share) => [50 + 50 * Math.sign(share) * (Math.abs(share) / WIDEST) ** 0.5, figure(share)]);
  frame.replaceChildren(
    el("figcaption", {}, planner(known[b]), " against ", planner(known[a]), " ",
      el("small", {}, "difference in % of A's figure (success: percentage points), with its 95 % interval; square-root axis; green: B better, red: B worse")),
    ...drawn.map((row) => forestRow(data.kpis[row[3]][1] + (data.kpis[row[3]][3] ? " †" : ""), data.kpis[row[3]][0] === "success" ? "percentage points" : "%",
      VERDICTS[row[4]], row[7], row[5], `${VERDICTS[row[4]] || "no direction"} · ${counted(row[6][0][1], "pair")}`)),
    axis(places));
}

if (comparisonTable) {
  document.querySelector('[data-table="comparison-table"]').addEventListener("input", showForest);
  views.comparisons = async (rest, params) => {
    await fillComparisons();
    restore(comparisonTable, params);
    await showForest();
  };
}
