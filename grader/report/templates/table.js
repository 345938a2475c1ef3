"use strict";
// Sorting, filtering, and a way back. Without it the page is whole and in the order of the ids.

const order = new Intl.Collator(undefined, { numeric: true, sensitivity: "base" });

function keyOf(row, column, kind) {
  const cell = row.cells[column];
  return kind === "number" ? Number(cell.dataset.key) : cell.textContent.trim();
}

function sort(table, heading, now) {
  for (const other of table.tHead.rows[0].cells) other.removeAttribute("aria-sort");
  heading.setAttribute("aria-sort", now);
  const kind = heading.dataset.sort;
  const sign = now === "ascending" ? 1 : -1;
  const body = table.tBodies[0];
  const keyed = Array.from(body.rows, (row) => [keyOf(row, heading.cellIndex, kind), row]);
  keyed.sort(([a], [b]) => sign * (kind === "number" ? a - b : order.compare(a, b)));
  body.remove(); // rows that are moved out of sight cost nothing
  body.append(...keyed.map(([, row]) => row));
  table.append(body);
}

function next(heading) {
  const first = heading.dataset.sort === "number" ? "descending" : "ascending"; // the largest number is looked for first
  const before = heading.getAttribute("aria-sort");
  return before === null ? first : before === "ascending" ? "descending" : "ascending";
}

for (const table of document.querySelectorAll("table.sortable")) {
  for (const heading of table.tHead.rows[0].cells) {
    if (!heading.dataset.sort) continue;
    const button = document.createElement("button");
    button.type = "button";
    button.append(...heading.childNodes);
    button.addEventListener("click", () => {
      sort(table, heading, next(heading));
      if (table === submissions) show();
    });
    heading.append(button);
  }
}

const submissions = document.getElementById("submissions");
const filters = document.getElementById("filters");
const find = document.getElementById("find");
const shown = document.getElementById("shown");
const clear = document.getElementById("clear");
const rest = document.getElementById("rest");
const atOnce = Number(submissions.dataset.atOnce); // rows that are laid out before all are asked for
const lists = new Map(Array.from(filters.querySelectorAll("[data-filter]"), (list) => [list.id, list]));
const choosers = Array.from(document.querySelectorAll("button[data-only]"));
let score = ""; // the bar that is chosen
let whole = false; // all rows were asked for

const facts = new Map(Array.from(submissions.tBodies[0].rows, (row) => {
  const text = Array.from(row.querySelectorAll("[data-find]"), (cell) => cell.textContent).join(" ");
  return [row, { text: text.toLocaleLowerCase(), tags: new Set(row.dataset.tags.split(" ")) }];
}));

function chosen(list) {
  return list === "score" ? score : lists.has(list) ? lists.get(list).value : "";
}

function choose(list, tag) {
  if (list === "score") score = tag;
  else lists.get(list).value = tag;
}

function show() {
  const words = find.value.trim().toLocaleLowerCase().split(/\s+/);
  const tags = ["score", ...lists.keys()].map(chosen).filter(Boolean);
  let count = 0;
  for (const row of submissions.tBodies[0].rows) {
    const known = facts.get(row);
    row.hidden = !(tags.every((tag) => known.tags.has(tag)) && words.every((word) => known.text.includes(word)));
    count += row.hidden ? 0 : 1;
    row.classList.toggle("more", !whole && count > atOnce);
  }
  shown.value = count === facts.size ? "" : `${count} of ${facts.size}`;
  clear.hidden = count === facts.size;
  for (const each of choosers) each.setAttribute("aria-pressed", String(chosen(each.dataset.list) === each.dataset.only));
  if (rest) {
    rest.hidden = whole || count <= atOnce;
    rest.querySelector("span").textContent = count;
  }
  keep();
}

// --- the way back ----------------------------------------------------------------------------------------------------

function keep() {
  const sorted = submissions.querySelector("th[aria-sort]");
  const values = Object.fromEntries(Array.from(lists, ([id, list]) => [id, list.value]));
  const by = sorted && [sorted.cellIndex, sorted.getAttribute("aria-sort")];
  history.replaceState({ find: find.value, values, score, whole, by }, "");
}

function restore(state) {
  if (!state) return;
  find.value = state.find;
  for (const [id, value] of Object.entries(state.values)) lists.get(id).value = value;
  score = state.score;
  whole = state.whole;
  if (state.by) sort(submissions, submissions.tHead.rows[0].cells[state.by[0]], state.by[1]);
}

document.addEventListener("click", (event) => {
  if (!event.target.closest('a[href^="submissions/"]')) return;
  const rows = Array.from(submissions.tBodies[0].rows).filter((row) => !row.hidden);
  const reports = rows.map((row) => row.querySelector("a")).filter(Boolean).map((link) => link.href);
  try {
    sessionStorage.setItem("imugrade", JSON.stringify({ index: location.href.split("#")[0], reports }));
  } catch {
    // nothing may be kept: the reports have no way to their neighbours
  }
});

// --- what is clicked -------------------------------------------------------------------------------------------------

find.addEventListener("input", show);
for (const list of lists.values()) list.addEventListener("change", show);
filters.addEventListener("submit", (event) => event.preventDefault());
filters.addEventListener("reset", (event) => {
  event.preventDefault(); // the browser empties the fields after this event, and what is shown would lag behind
  find.value = score = "";
  for (const list of lists.values()) list.value = "";
  show();
});
if (rest) {
  rest.firstChild.addEventListener("click", () => {
    whole = true;
    show();
  });
}
for (const button of choosers) {
  const { list, only } = button.dataset;
  if (!only || (list !== "score" && !lists.has(list))) continue;
  button.disabled = false;
  button.addEventListener("click", () => {
    choose(list, chosen(list) === only ? "" : only);
    show();
    filters.scrollIntoView({ block: "nearest" });
  });
}
filters.hidden = false;
restore(history.state);
show();
