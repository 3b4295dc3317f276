"use strict";
// Sorting, filtering and choosing. The state of the table of trials and the chosen KPI live in the address:
// #sort=-seed&filter=text&scenario=...&planner=...&outcome=...&kpi=...
(() => {
  const all = (selector, root = document) => [...root.querySelectorAll(selector)];
  const kpiSelect = document.getElementById("kpi-select");
  const address = { read: () => new URLSearchParams(location.hash.includes("=") ? location.hash.slice(1) : "") };
  address.write = (key, value) => {
    const state = address.read();
    if (value) state.set(key, value); else state.delete(key);
    const text = state.toString();
    history.replaceState(null, "", text ? "#" + text : location.pathname + location.search);
  };

  const headText = (head) => head.textContent.trim();
  const valueOf = (row, column) => {
    const cell = row.cells[column];
    if (cell.dataset.v !== undefined) return Number(cell.dataset.v);
    return cell.classList.contains("num") ? null : cell.textContent.trim();
  };
  const compare = (a, b) => (typeof a === "number" ? a - b : a.localeCompare(b, undefined, { numeric: true }));

  function sort(table, column, descending) {
    const heads = all("thead th", table);
    heads.forEach((head, index) => {
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

  function filter(controls) {
    const table = document.getElementById(controls.dataset.table);
    const fields = all("[data-column]", controls).map((field) => [field.dataset.column, field.value]);
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
    controls.querySelector("output").textContent = `${shown} of ${table.tBodies[0].rows.length} shown`;
  }

  function choose(name) {
    if (!kpiSelect) return;
    if (![...kpiSelect.options].some((option) => option.value === name)) name = "success";
    kpiSelect.value = name;
    all(".kpi").forEach((figure) => figure.classList.toggle("chosen", figure.dataset.kpi === name));
  }

  function restore() {
    const state = address.read();
    choose(state.get("kpi") || "success");
    const table = document.querySelector("[data-permalink]");
    if (!table) return;
    const wanted = state.get("sort") || "";
    const descending = wanted.startsWith("-");
    const column = all("thead th", table).findIndex((head) => headText(head) === wanted.replace(/^-/, ""));
    if (column >= 0) sort(table, column, descending);
    const controls = document.querySelector(`[data-table="${table.id}"]`);
    all("[data-column]", controls).forEach((field) => { field.value = state.get(field.dataset.column) || ""; });
    filter(controls);
  }

  function copied(button, done) {
    document.getElementById("status").textContent = done ? "Copied." : "Could not copy; select the text instead.";
    button.textContent = done ? "copied" : "select";
    setTimeout(() => { button.textContent = "copy"; }, 1500);
  }

  function copyBySelection(element) {
    const range = document.createRange();
    range.selectNodeContents(element);
    getSelection().removeAllRanges();
    getSelection().addRange(range);
    return document.execCommand("copy");
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
    const table = head.closest("table");
    const descending = head.getAttribute("aria-sort") === "ascending";
    sort(table, head.cellIndex, descending);
    if ("permalink" in table.dataset) address.write("sort", (descending ? "-" : "") + headText(head));
  });

  all(".controls[data-table]").forEach((controls) => {
    const table = document.getElementById(controls.dataset.table);
    controls.addEventListener("input", (event) => {
      filter(controls);
      if ("permalink" in table.dataset) address.write(event.target.dataset.column, event.target.value);
    });
    filter(controls);
  });
  all("input[type=checkbox][data-planner]").forEach((box) => box.addEventListener("change", () => {
    all("[data-planner]", document.getElementById("pictures")).forEach((element) => {
      if (element !== box && element.dataset.planner === box.dataset.planner && element.tagName !== "INPUT") {
        element.classList.toggle("off", !box.checked);
      }
    });
  }));
  if (kpiSelect) kpiSelect.addEventListener("change", () => { choose(kpiSelect.value); address.write("kpi", kpiSelect.value); });
  addEventListener("hashchange", () => { if (location.hash.includes("=")) restore(); });
  // On a phone, rows become cards: each figure then needs its heading beside it.
  all("table.cards").forEach((table) => {
    const heads = all("thead th", table).map(headText);
    all("tbody .num", table).forEach((cell) => { cell.dataset.label = heads[cell.cellIndex]; });
  });
  document.documentElement.classList.add("js");
  restore();
})();
