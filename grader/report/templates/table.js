"use strict";
// Sorting and filtering. Without it the page is whole and in the order of the ids.

const order = new Intl.Collator(undefined, { numeric: true, sensitivity: "base" });

function keyOf(row, column, kind) {
  const cell = row.cells[column];
  return kind === "number" ? Number(cell.dataset.key) : cell.textContent.trim();
}

function sort(table, heading) {
  const kind = heading.dataset.sort;
  const before = heading.getAttribute("aria-sort");
  const first = kind === "number" ? "descending" : "ascending"; // the largest number is looked for first
  const now = before === null ? first : before === "ascending" ? "descending" : "ascending";
  for (const other of table.tHead.rows[0].cells) other.removeAttribute("aria-sort");
  heading.setAttribute("aria-sort", now);
  const sign = now === "ascending" ? 1 : -1;
  const body = table.tBodies[0];
  const keyed = Array.from(body.rows, (row) => [keyOf(row, heading.cellIndex, kind), row]);
  keyed.sort(([a], [b]) => sign * (kind === "number" ? a - b : order.compare(a, b)));
  body.append(...keyed.map(([, row]) => row));
}

for (const table of document.querySelectorAll("table.sortable")) {
  for (const heading of table.tHead.rows[0].cells) {
    if (!heading.dataset.sort) continue;
    const button = document.createElement("button");
    button.type = "button";
    button.append(...heading.childNodes);
    button.addEventListener("click", () => sort(table, heading));
    heading.append(button);
  }
}

const filters = document.getElementById("filters");
const find = document.getElementById("find");
const only = document.getElementById("only");
const shown = document.getElementById("shown");
const rows = Array.from(document.getElementById("submissions").tBodies[0].rows, (row) => {
  const text = Array.from(row.querySelectorAll("[data-find]"), (cell) => cell.textContent).join(" ");
  return { row, text: text.toLocaleLowerCase(), tags: row.dataset.tags.split(" ") };
});

function filter() {
  const words = find.value.trim().toLocaleLowerCase().split(/\s+/);
  let count = 0;
  for (const { row, text, tags } of rows) {
    const tagged = !only.value || tags.includes(only.value);
    row.hidden = !tagged || !words.every((word) => text.includes(word));
    count += row.hidden ? 0 : 1;
  }
  shown.value = count === rows.length ? "" : `${count} of ${rows.length}`;
}

find.addEventListener("input", filter);
only.addEventListener("change", filter);
filters.addEventListener("submit", (event) => event.preventDefault());
filters.hidden = false;

for (const button of document.querySelectorAll("button[data-only]")) {
  if (!Array.from(only.options).some((option) => option.value === button.dataset.only)) continue;
  button.disabled = false;
  button.addEventListener("click", () => {
    only.value = button.dataset.only;
    find.value = "";
    filter();
    filters.scrollIntoView();
    only.focus({ preventScroll: true });
  });
}
