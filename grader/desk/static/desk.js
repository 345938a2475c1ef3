"use strict";

// A key follows the link, or presses the button, that carries it; never while somebody writes.
document.addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.metaKey || event.altKey || event.target.closest("input, textarea, select")) return;
  const wanted = Array.from(document.querySelectorAll("[data-key]")).find((each) => each.dataset.key === event.key);
  if (wanted) {
    event.preventDefault();
    wanted.focus();
    wanted.click();
  }
});

// What is opened is written into.
for (const each of document.querySelectorAll(".by-hand > details")) {
  each.addEventListener("toggle", () => each.open && each.querySelector("input:not([type=hidden])").focus());
}

// A text file that is dropped on a field, or chosen beside it, is read into it.
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
