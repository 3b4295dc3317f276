// The page of one trial: how it ended, how to repeat it, its motion and its KPIs beside another planner's.
let trialPlayer = null;

const rowOf = (id) => all("#trial-table tbody tr").find((row) => row.dataset.node === id);

function command(code, name) {
  return el("div", { class: "command" }, el("code", { tabindex: 0 }, code), el("button", { type: "button", class: "copy", "aria-label": "Copy the command " + name }, "copy"));
}

// Words and commands stand in the table of trials.
function wordsOf(index, trial) {
  const row = rowOf(trial[0]);
  if (!row) return [];
  const repeat = row.querySelector("code")?.textContent;
  const [folder, where] = runFolder(index.runs[trial[8]]);
  return [
    ...all(".words p", row).map((text) => el("p", { class: text.className }, text.textContent)),
    ...(repeat ? [el("p", { class: "quiet" }, "Repeat it, in the folder in which the run was started:"), command(repeat, "that repeats the trial")] : []),
    el("p", { class: "quiet" }, `Draw it as a video${where}:`),
    command(`lpb-report ${folder} --trial ${quoted(trial[9] || trial[0])} --video trial.mp4`, "that draws a video"),
  ];
}
const quoted = (text) => (/^[\w@%+=:,./][\w@%+=:,./-]*$/.test(text) ? text : `'${text.replaceAll("'", "'\"'\"'")}'`);

// A run's folder as it is typed. The page knows where it lies itself, wherever it was moved to.
function runFolder([name, address]) {
  try {
    if (location.protocol !== "file:") throw new Error("not on this machine");
    const path = decodeURIComponent(new URL(address, location.href).pathname).replace(/(.)\/$/, "$1");
    const own = path.endsWith("/latest") ? path.slice(0, -6) + name : path; // `latest` leads to another run soon
    return [/^\/[A-Za-z]:\//.test(own) ? `"${own.slice(1)}"` : quoted(own), ""];
  } catch {
    return [quoted(name), ", in the folder that holds the run"];
  }
}

function kpiTable(index, trial, other) {
  const medians = index.medians[trial[2]][trial[1]] || [];
  const rows = index.kpis.map(([group, title], place) => [group, title, trial[6][place], medians[place] || "–", other?.[6][place]])
    .filter(([, , own, median, its]) => own !== "–" || median !== "–" || (its && its !== "–"));
  const name = (chosen) => index.planners[chosen[2]].name;
  return el("div", { class: "scroll", tabindex: 0, role: "region", "aria-label": "KPIs" }, el("table", { class: "data" },
    el("thead", {}, el("tr", {}, el("th", { scope: "col" }, "KPI"), el("th", { scope: "col", class: "num" }, "this trial"),
      other ? el("th", { scope: "col", class: "num" }, name(other)) : "",
      el("th", { scope: "col", class: "num" }, `median of ${name(trial)} here`), el("th", { scope: "col" }, "group"))),
    el("tbody", {}, rows.map(([group, title, own, median, its]) => el("tr", {}, el("th", { scope: "row" }, title),
      el("td", { class: "num" }, own), other ? el("td", { class: "num" }, its) : "", el("td", { class: "num" }, median), el("td", {}, group))))));
}

function neighbours(index, trial) {
  const own = index.trials.filter((other) => other[1] === trial[1] && other[2] === trial[2]).sort((a, b) => a[3] - b[3]);
  const place = own.indexOf(trial);
  const link = (other, text) => (other ? el("a", { href: trialLink(other[0]) }, text + " seed " + other[3]) : "");
  return el("span", { class: "neighbours" }, link(own[place - 1], "←"), " ", link(own[place + 1], "→"));
}

function choices(index, trial, others, params) {
  const select = el("select", { autocomplete: "off", id: "with" }, el("option", { value: "" }, "nobody"),
    others.map((other) => el("option", { value: other[0] }, `${index.planners[other[2]].name}: ${words(other[4])}`)));
  select.value = params.get("with") || "";
  const layout = el("select", { autocomplete: "off", id: "layout" }, el("option", { value: "" }, "side by side"), el("option", { value: "overlay" }, "in one picture"));
  layout.value = params.get("layout") || "";
  layout.disabled = !select.value;
  for (const [field, key] of [[select, "with"], [layout, "layout"]]) {
    field.addEventListener("change", async () => {
      address.write({ [key]: field.value });
      await views.trial(trial[0], address.read().params);
      document.getElementById(field.id)?.focus();
    });
  }
  return el("p", { class: "controls" }, el("label", {}, "Beside ", select), el("label", {}, "Shown ", layout));
}

async function motionOf(index, trial, other, layout) {
  const place = index.trials.indexOf(trial);
  if (!blocks.has("trial:" + place)) {
    return el("p", { class: "note" }, "This trial has neither time series nor a replay in this report; the commands above show it.");
  }
  const tracks = await Promise.all([trial, other].filter(Boolean).map((chosen) =>
    loadTrack(index.trials.indexOf(chosen), index.planners[chosen[2]], chosen)));
  trialPlayer = new Player(tracks, layout, (t) => address.write({ t: t > 0 ? t.toFixed(2) : "" }));
  const { more } = tracks[0];
  return el("div", {}, trialPlayer.node, more.length ? el("p", { class: "quiet" }, `Of what the planner recorded, the trial's file has also: ${more.join(", ")}.`) : "");
}

views.trial = async (id, params) => {
  const index = await unpack("index");
  const trial = index.trials.find((known) => known[0] === id);
  trialPlayer?.close();
  trialPlayer = null;
  const body = document.getElementById("trial-body"), title = document.getElementById("trial-title"), crumbs = document.querySelector("#trial .crumbs");
  if (!trial) {
    title.textContent = "No such trial in this report";
    crumbs.replaceChildren(el("a", { href: "#/trials" }, "all trials"));
    body.replaceChildren(el("p", {}, id));
    return null;
  }
  const [, scenario, plannerPlace, seed, , problem] = trial;
  const style = index.planners[plannerPlace], name = index.scenarios[scenario];
  // Trials of one problem, by other planners first, that have a replay to be shown beside this one.
  const others = index.trials.filter((other, place) => other !== trial && other[1] === scenario && other[3] === seed
    && other[5] === problem && blocks.has("trial:" + place));
  const other = others.find((known) => known[0] === params.get("with"));
  const motion = await motionOf(index, trial, other, params.get("layout"));
  crumbs.replaceChildren(el("a", { href: "#/trials" }, "trials"), " / ", el("a", { href: "#/scenario/" + encodeURIComponent(name) }, name), " ", neighbours(index, trial));
  title.replaceChildren(planner(style), ` on ${name}, seed ${seed} `, chip(trial));
  body.replaceChildren(el("div", { class: "words" }, ...wordsOf(index, trial)),
    trialPlayer && others.length ? choices(index, trial, others, params) : "", motion,
    el("h3", {}, "KPIs"), kpiTable(index, trial, other));
  trialPlayer?.show(Number(params.get("t")) || 0);
  return `${style.name} on ${name}, seed ${seed}`;
};
