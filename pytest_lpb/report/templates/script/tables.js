// Sorting, filtering, copying; rows as cards on a phone.
const headText = (head) => head.textContent.trim();

function valueOf(row, column) {
  const cell = row.cells[column];
  if (cell.dataset.v !== undefined) return Number(cell.dataset.v);
  return cell.classList.contains("num") ? null : cell.textContent.trim();
}
const compare = (a, b) => (typeof a === "number" ? a - b : a.localeCompare(b, undefined, { numeric: true }));

function sort(table, column, descending) {
  all("thead th", table).forEach((head, index) => {
    if (index === column) head.setAttribute("aria-sort", descending ? "descending" : "ascending");
    else head.removeAttribute("aria-sort");
  });
  const body = table.tBodies[0];
  const rows = [...body.rows].map((row) => [valueOf(row, column), row]);
  // Empty cells come last, whichever way the others are sorted.
  rows.sort(([a], [b]) => {
    if (a === null || b === null) return (a === null) - (b === null);
    return descending ? compare(b, a) : compare(a, b);
  });
  body.append(...rows.map(([, row]) => row));
}

const fieldsOf = (table) => all(`[data-table="${table.id}"] [data-column]`);

function filter(table) {
  const fields = fieldsOf(table).map((field) => [field.dataset.column, field.value]);
  let shown = 0;
  for (const row of table.tBodies[0].rows) {
    const visible = fields.every(([column, value]) => {
      if (!value) return true;
      if (column !== "filter") return row.dataset[column] === value;
      const text = row.textContent.toLowerCase();
      return value.toLowerCase().split(/\s+/).every((word) => text.includes(word));
    });
    row.hidden = !visible;
    shown += visible;
  }
  document.querySelector(`[data-table="${table.id}"] output`).textContent = `${shown} of ${table.tBodies[0].rows.length} shown`;
}

// On a phone, rows become cards: each figure then needs its heading beside it.
function label(table) {
  const heads = all("thead th", table).map(headText);
  all("tbody .num", table).forEach((cell) => { cell.dataset.label = heads[cell.cellIndex]; });
}

// What the address says of a table's order: ?sort=-seed
function restoreOrder(table, params) {
  const wanted = params.get("sort") || "";
  const column = all("thead th", table).findIndex((head) => headText(head) === wanted.replace(/^-/, ""));
  if (wanted && column >= 0) sort(table, column, wanted.startsWith("-"));
}

// And of what is filtered: &scenario=...; other fields are as the page made them.
function restore(table, params) {
  restoreOrder(table, params);
  fieldsOf(table).forEach((field) => {
    const given = params.get(field.dataset.column)?.replace(/^any$/, "");
    const known = field.tagName !== "SELECT" || [...field.options].some((option) => option.value === given);
    if (given !== undefined && known) field.value = given;
    else if (field.tagName !== "SELECT") field.value = "";
    else field.selectedIndex = Math.max([...field.options].findIndex((option) => option.defaultSelected), 0);
  });
  filter(table);
}

function copyBySelection(element) {
  const range = document.createRange();
  range.selectNodeContents(element);
  getSelection().removeAllRanges();
  getSelection().addRange(range);
  return document.execCommand("copy");
}

function copied(button, done) {
  document.getElementById("status").textContent = done ? "Copied." : "Could not copy; select the text instead.";
  button.textContent = done ? "copied" : "select";
  setTimeout(() => { button.textContent = "copy"; }, 1500);
}

document.addEventListener("click", (event) => {
  const button = event.target.closest("button");
  if (!button) return;
  if (button.classList.contains("copy")) {
    const code = button.previousElementSibling;
    if (!navigator.clipboard) { copied(button, copyBySelection(code)); return; }
    navigator.clipboard.writeText(code.textContent).then(() => copied(button, true), () => copied(button, copyBySelection(code)));
    return;
  }
  const head = button.closest(".sortable th");
  if (!head) return;
  const descending = head.getAttribute("aria-sort") === "ascending";
  sort(head.closest("table"), head.cellIndex, descending);
  address.write({ sort: (descending ? "-" : "") + headText(head) });
});

all(".controls[data-table]").forEach((controls) => controls.addEventListener("input", (event) => {
  filter(document.getElementById(controls.dataset.table));
  const field = event.target;
  const standard = field.tagName === "SELECT" ? [...field.options].find((option) => option.defaultSelected)?.value || "" : "";
  // `any` says that a filter which is set by default was taken off.
  address.write({ [field.dataset.column]: field.value === standard ? "" : field.value || "any" });
}));

const trialTable = document.getElementById("trial-table");
views.trials = (rest, params) => restore(trialTable, params);
