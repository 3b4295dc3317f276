// Pictures of all scenarios, or the page of one with its trials and KPIs.
const articles = all("#scenarios article");

all("input[type=checkbox][data-planner]").forEach((box) => box.addEventListener("change", () => {
  all("#scenarios [data-planner]").forEach((element) => {
    if (element.tagName !== "INPUT" && element.dataset.planner === box.dataset.planner) element.classList.toggle("off", !box.checked);
  });
}));

function seedTable(index, trials) {
  const shown = index.planners.filter((style) => trials.some((trial) => index.planners[trial[2]] === style));
  const seeds = [...new Set(trials.map((trial) => trial[3]))].sort((a, b) => a - b);
  const found = new Map(trials.map((trial) => [`${trial[3]} ${trial[2]}`, trial]));
  const cell = (seed, style) => {
    const trial = found.get(`${seed} ${index.planners.indexOf(style)}`);
    if (!trial) return el("td", {}, "–");
    const replay = blocks.has("trial:" + index.trials.indexOf(trial)) ? " ▶" : "";
    return el("td", {}, chip(trial, trialLink(trial[0])), replay);
  };
  return el("div", { class: "scroll tall", tabindex: 0, role: "region", "aria-label": "Trials of this scenario" }, el("table", {},
    el("thead", {}, el("tr", {}, el("th", { scope: "col" }, "seed"), shown.map((style) => el("th", { scope: "col" }, planner(style))))),
    el("tbody", {}, seeds.map((seed) => el("tr", {}, el("th", { scope: "row" }, String(seed)), shown.map((style) => cell(seed, style)))))));
}

function kpiChoice(scenario) {
  const select = el("select", { autocomplete: "off" }, ...[...kpiSelect.children].map((child) => child.cloneNode(true)));
  const place = el("div");
  const show = async () => place.replaceChildren(await kpiFigure(select.value, scenario));
  select.addEventListener("change", () => { show(); address.write({ kpi: select.value === "success" ? "" : select.value }); });
  const wanted = address.read().params.get("kpi");
  if (wanted && [...select.options].some((option) => option.value === wanted)) select.value = wanted; else select.value = "success";
  show();
  return [el("p", { class: "controls" }, el("label", {}, "Show ", select)), place];
}

async function moreOf(scenario) {
  const index = await unpack("index");
  const place = index.scenarios.indexOf(scenario);
  const trials = index.trials.filter((trial) => trial[1] === place);
  const table = "#/trials?scenario=" + encodeURIComponent(scenario);
  const compared = "#/comparisons?scenario=" + encodeURIComponent(scenario);
  return [
    el("h4", {}, "Trials ", el("small", {}, "▶ with a replay · "), el("a", { href: table }, "as a table"),
      comparisonTable ? [" · ", el("a", { href: compared }, "comparisons here")] : ""),
    seedTable(index, trials),
    ...(kpiSelect ? [el("h4", {}, "Success and KPIs"), ...kpiChoice(scenario)] : []),
  ];
}

views.scenarios = () => {
  articles.forEach((article) => { article.hidden = false; article.querySelector(".more").replaceChildren(); });
  document.getElementById("scenarios-title").textContent = "Scenarios";
};

views.scenario = async (scenario) => {
  const more = await moreOf(scenario);
  articles.forEach((article) => {
    article.hidden = article.dataset.scenario !== scenario;
    article.querySelector(".more").replaceChildren(...(article.hidden ? [] : more));
  });
  const known = articles.some((article) => !article.hidden);
  document.getElementById("scenarios-title").textContent = known ? "Scenario" : `No scenario ${scenario} in this report`;
  return scenario;
};
