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
  if (details && !typing() && !details.dataset.restored && details.matches(".override > details[open]")) details.querySelector("input:not([type=hidden])").focus();
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

// What is typed is kept as a draft until its form is sent, so that another page, a reload or a restart loses nothing. The browser
// asks before it leaves a page whose draft could not be kept.
const LARGEST_LEFT_BEHIND = 60000; // characters of a request that a browser still sends when its page is gone: less than 64 kB
const unkept = new Map(); // forms with changes that are not kept yet
function typed(form) {
  const fields = Array.from(form.elements).filter((each) => each.name && (each.type !== "hidden" || "kept" in each.dataset));
  const chosen = fields.filter((each) => !["checkbox", "submit", "file"].includes(each.type) || each.checked);
  return chosen.map((each) => [each.name, each.value]);
}
async function keep(form, fields) {
  const text = JSON.stringify(fields);
  const body = new URLSearchParams({ draft: form.elements.draft.value, fields: text });
  const keepalive = body.toString().length < LARGEST_LEFT_BEHIND;
  const kept = await fetch("/draft", { method: "POST", body, keepalive }).then((answer) => answer.ok, () => false);
  if (!kept) unkept.set(form, "failed");
  else if (!fields.length || text === JSON.stringify(typed(form))) unkept.delete(form);
}
function restore(form, fields) {
  let overtaken = false; // by a change of these points after the draft was typed; the form must still be sent with what this page shows
  for (const each of form.elements) if (each.type === "checkbox") each.checked = false;
  for (const [name, value] of fields) {
    const several = form.querySelectorAll(`[name="${CSS.escape(name)}"]`);
    for (const each of several) {
      if (name === "seen") overtaken = each.value !== value;
      else if (each.type !== "checkbox") each.value = value;
      else if (each.value === value) each.checked = true;
    }
  }
  const text = form.querySelector(".edit textarea");
  if (text) text.dispatchEvent(new Event("input")); // for the line numbers
  const details = form.closest("details");
  if (details) details.dataset.restored = details.open = true;
  const note = document.createElement("p");
  note.className = "banner unsaved";
  const discard = document.createElement("button");
  Object.assign(discard, { type: "button", className: "small", textContent: "Discard" });
  discard.addEventListener("click", () => keep(form, []).then(() => location.reload()));
  note.append("Not saved yet. ", overtaken ? "What this page shows was changed after you typed this: look at it before you save. " : "", discard);
  form.prepend(note);
}
document.addEventListener("DOMContentLoaded", () => {
  const drafts = JSON.parse(document.getElementById("main").dataset.drafts || "{}");
  for (const { form } of document.querySelectorAll("input[name=draft]")) {
    let timer = 0;
    const draft = drafts[form.elements.draft.value];
    if (form.dataset.typed === "keep") keep(form, typed(form));
    else if (draft && !("typed" in form.dataset)) restore(form, draft);
    form.addEventListener("input", () => {
      unkept.set(form, "soon");
      clearTimeout(timer);
      timer = setTimeout(() => keep(form, typed(form)), 300);
    });
    form.addEventListener("submit", () => {
      unkept.delete(form);
      clearTimeout(timer);
    });
    for (const link of form.querySelectorAll("[data-discard]")) link.addEventListener("click", () => {
      unkept.delete(form);
      keep(form, []);
    });
  }
});
addEventListener("beforeunload", (event) => {
  for (const [form, state] of unkept) {
    if (state === "failed" || JSON.stringify(typed(form)).length > LARGEST_LEFT_BEHIND / 3) event.preventDefault();
    else keep(form, typed(form));
  }
});
