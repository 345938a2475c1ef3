"use strict";

const form = document.getElementById("marking");
const done = document.getElementById("done");
const { columns, rubric } = form.dataset;
const rows = [...form.querySelectorAll("fieldset[data-id]")].map((part) => {
  const [points, comment] = part.querySelectorAll("input");
  return { ...part.dataset, points, comment };
});
const draft = `imugrade marks ${rubric} ${rows.map((row) => row.id).join(" ")}`;
let saved = true;

// A draft in the browser survives a closed page; where none may be kept, the question on leaving stays.
try {
  const kept = JSON.parse(localStorage.getItem(draft)) ?? [];
  kept.forEach(([points, comment], at) => Object.assign(rows[at].points, { value: points }) && Object.assign(rows[at].comment, { value: comment }));
} catch {
  // nothing was kept
}

function count() {
  const given = rows.filter((row) => row.points.value !== "").length;
  done.textContent = `${given} of ${rows.length} fields have points${saved ? "" : ", not saved yet"}`;
}

function changed() {
  saved = false;
  try {
    localStorage.setItem(draft, JSON.stringify(rows.map((row) => [row.points.value, row.comment.value])));
  } catch {
    // nothing may be kept
  }
  count();
}

// A spreadsheet takes a text that begins like a formula for one.
const cell = (text) => `"${(/^[=+\-@\t\r]/.test(text) ? `'${text}` : text).replaceAll('"', '""')}"`;

form.addEventListener("input", changed);
form.addEventListener("click", ({ target }) => {
  if (!target.classList.contains("full")) return;
  for (const input of target.closest(".give").querySelectorAll("input[type=number]")) if (input.value === "") input.value = input.max;
  changed();
});
form.addEventListener("submit", (event) => {
  event.preventDefault();
  const fields = { rubric };
  const line = (row) => columns.split(",").map((name) => cell(row[name]?.value ?? row[name] ?? fields[name] ?? "")).join(",");
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([[columns, ...rows.map(line), ""].join("\r\n")], { type: "text/csv" }));
  link.download = "marks.csv";
  link.click();
  saved = true;
  count();
});
window.addEventListener("beforeunload", (event) => {
  if (!saved) event.preventDefault();
});
count();
