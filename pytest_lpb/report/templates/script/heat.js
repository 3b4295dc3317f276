// The heat map: success as the page was made, or the medians of a KPI.
const heatSelect = document.getElementById("heat-select");
const heatRows = () => all("#heat tbody tr").map((row) => all("td:not(.ahead)", row));
let successCells = null;

// 1 for the best of a row, 0 for the worst; null where there is nothing to rank.
function ranks(cells, direction) {
  const values = cells.filter(Boolean).map((cell) => cell[1]);
  const [low, high] = [Math.min(...values), Math.max(...values)];
  if (direction === "none" || values.length < 2 || low === high) return cells.map(() => null);
  return cells.map((cell) => cell && (direction === "higher" ? cell[1] - low : high - cell[1]) / (high - low));
}

async function showHeat(name) {
  const data = await unpack("heat");
  successCells ||= heatRows().map((cells) => cells.map((cell) => cell.cloneNode(true)));
  if (!data[name]) name = "success";
  heatSelect.value = name;
  const title = heatSelect.selectedOptions[0].textContent;
  const better = { lower: ", lower is better", higher: ", higher is better", none: "" }[data[name]?.[0]];
  document.getElementById("heat-note").textContent = data[name]
    ? `median ${title}${better}; the best of each row is darkest; below: quartiles and how many problems have a value`
    : "trials solved; success rate with its 95 % interval";
  heatRows().forEach((cells, row) => {
    if (!data[name]) { cells.forEach((cell, place) => cell.replaceWith(successCells[row][place].cloneNode(true))); return; }
    const [direction, rows] = data[name];
    const shares = ranks(rows[row], direction);
    cells.forEach((cell, place) => {
      const found = rows[row][place];
      cell.className = shares[place] === null || !found ? "" : "heat";
      cell.style.setProperty("--rate", shares[place] ?? 0);
      cell.replaceChildren(el("b", {}, found ? found[0] : "–"), found ? el("small", {}, found[2]) : "");
    });
  });
}

// On a phone, what lies to the right is not seen to be there.
const heatHint = document.querySelector(".scroll-hint");
if (heatHint) {
  const box = heatHint.nextElementSibling;
  const observer = new ResizeObserver(() => { heatHint.hidden = box.scrollWidth <= box.clientWidth; });
  [box, box.firstElementChild].forEach((part) => observer.observe(part));
}

if (heatSelect) {
  heatSelect.addEventListener("change", () => {
    showHeat(heatSelect.value);
    address.write({ kpi: heatSelect.value === "success" ? "" : heatSelect.value });
  });
  views.overview = (rest, params) => showHeat(params.get("kpi") || "success");
}
