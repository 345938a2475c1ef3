"use strict";

// A key follows the link, or presses the button, that carries it; never while somebody writes. One that comes before the whole
// page is there waits for it.
const carrier = (key) => document.querySelector(`[data-key~="${CSS.escape(key)}"]`);
function follow(key) {
  const wanted = carrier(key);
  if (wanted) {
    wanted.focus();
    wanted.click();
  }
}
document.addEventListener("keydown", (event) => {
  const field = event.target.closest("input, textarea, select");
  if (field && event.key === "Escape") field.blur();
  if (field && event.key === "Enter" && (event.ctrlKey || event.metaKey)) field.form.requestSubmit(field.form.querySelector("button"));
  if (field || event.ctrlKey || event.metaKey || event.altKey) return;
  if (carrier(event.key)) event.preventDefault();
  if (document.readyState !== "loading") follow(event.key);
  else document.addEventListener("DOMContentLoaded", () => follow(event.key), { once: true });
});

// What is opened is written into.
document.addEventListener("toggle", (event) => {
  if (event.target.matches(".override > details[open]")) event.target.querySelector("input:not([type=hidden])").focus();
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
