"use strict";

// A key follows the link, or presses the button, that carries it; never while somebody writes. One that comes before the whole
// page is there waits for it. A form that a key opens takes the next key at once.
const carrier = (key) => document.querySelector(`[data-key~="${CSS.escape(key)}"]`);
const typing = () => document.activeElement.closest("input, textarea, select");
function follow(key) {
  const wanted = carrier(key);
  if (typing()) document.execCommand("insertText", false, key.length === 1 ? key : "");
  else if (wanted) {
    wanted.focus();
    wanted.click();
    write(wanted.closest("details"));
  }
}
function write(details) {
  if (details && !typing() && details.matches(".override > details[open]")) details.querySelector("input:not([type=hidden])").focus();
}
// The button of a field: that of its group, else the first of the form that stands in no group.
function chief(field) {
  const group = field.closest("fieldset");
  return (group && group.querySelector("button")) || field.form.querySelector("button:not(fieldset button)") || field.form.querySelector("button");
}
document.addEventListener("keydown", (event) => {
  const field = event.target.closest("input, textarea, select");
  if (field && event.key === "Escape") field.blur();
  if (field && event.key === "Enter" && (event.ctrlKey || event.metaKey)) field.form.requestSubmit(chief(field));
  if (field || event.ctrlKey || event.metaKey || event.altKey) return;
  if (carrier(event.key)) event.preventDefault();
  if (document.readyState !== "loading") follow(event.key);
  else document.addEventListener("DOMContentLoaded", () => follow(event.key), { once: true });
});

// What is opened is written into.
document.addEventListener("toggle", (event) => {
  write(event.target);
}, true);

// An earlier comment is copied into the form.
document.addEventListener("DOMContentLoaded", () => {
  const earlier = Array.from(document.querySelectorAll("#comments option"), (option) => option.value);
  for (const list of earlier.length ? document.querySelectorAll("select[data-reuse]") : []) {
    list.append(...earlier.map((text) => new Option(text, text)));
    list.closest("label").hidden = false;
    list.addEventListener("change", () => {
      if (list.value) list.form.elements.comment.value = list.value;
    });
  }
});

// A text file that is dropped on a field, or chosen beside it, is read into it.
document.addEventListener("DOMContentLoaded", () => {
  for (const field of document.querySelectorAll("textarea[data-drop]")) {
    const take = (file) => file && file.size <= 1000000 && file.text().then((text) => { field.value = text; });
    field.addEventListener("dragover", (event) => event.preventDefault());
    field.addEventListener("drop", (event) => {
      event.preventDefault();
      take(event.dataTransfer.files[0]);
    });
    const chooser = document.getElementById(field.dataset.drop);
    if (chooser) chooser.addEventListener("change", () => take(chooser.files[0]));
  }
});

// The page is loaded again while the grader works on something; a field that was refused has the cursor.
document.addEventListener("DOMContentLoaded", () => {
  if (document.querySelector("[data-reload]")) setTimeout(() => location.reload(), 1000);
  const wrong = document.querySelector("[aria-invalid]");
  if (wrong) wrong.focus();
});

// The editor: line numbers follow the text, Enter keeps the indentation, and a link to a line puts the cursor there.
document.addEventListener("DOMContentLoaded", () => {
  const field = document.querySelector(".edit textarea");
  if (!field) return;
  const gutter = document.querySelector(".edit .gutter");
  const lines = () => field.value.split("\n");
  function number() {
    const many = lines().length;
    while (gutter.children.length > many) gutter.lastElementChild.remove();
    while (gutter.children.length < many) {
      const next = document.createElement("li");
      next.textContent = gutter.children.length + 1;
      gutter.append(next);
    }
    field.rows = many + 1;
  }
  function go(line) {
    const start = lines().slice(0, line - 1).reduce((sum, each) => sum + each.length + 1, 0);
    field.focus({ preventScroll: true });
    field.setSelectionRange(start, start);
    if (gutter.children[line - 1]) gutter.children[line - 1].scrollIntoView({ block: "center" });
  }
  field.addEventListener("input", number);
  field.addEventListener("keydown", (event) => {
    if (event.key !== "Enter" || event.ctrlKey || event.metaKey || event.isComposing) return;
    const before = field.value.slice(0, field.selectionStart);
    const indent = before.slice(before.lastIndexOf("\n") + 1).match(/^[ \t]*/)[0];
    if (indent && document.execCommand("insertText", false, `\n${indent}`)) event.preventDefault();
  });
  for (const link of document.querySelectorAll("[data-line]")) {
    link.addEventListener("click", (event) => {
      event.preventDefault();
      go(Number(link.dataset.line));
    });
  }
});
