"use strict";

// The regrade request: a small file, or an e-mail. Nothing leaves the page by itself.
const regrade = document.getElementById("regrade");
if (regrade) {
  const { check, text } = regrade.elements;
  const { submission, lab } = regrade.dataset;
  const mail = document.getElementById("regrade-mail");
  const prepare = () => {
    const body = [`Submission: ${submission}`, `Check: ${check.value || "whole submission"}`, "", text.value].join("\r\n");
    mail.href = `mailto:?subject=${encodeURIComponent(`${lab}: regrade request`)}&body=${encodeURIComponent(body)}`;
  };
  regrade.addEventListener("input", prepare);
  regrade.addEventListener("submit", (event) => {
    event.preventDefault();
    const record = JSON.stringify({ submission, check: check.value, text: text.value }, null, 2);
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([`${record}\n`], { type: "application/json" }));
    link.download = `regrade-request-${submission}.json`;
    link.click();
  });
  prepare();
  regrade.hidden = false;
}

// Previous, next and class for whoever came from the class page: it leaves the reports here, in the order in which it shows them.

function left() {
  try {
    return JSON.parse(sessionStorage.getItem("imugrade"));
  } catch {
    return null; // nothing was left, or nothing may be kept
  }
}

function point(id, href) {
  const link = document.getElementById(id);
  if (href !== undefined && new URL(href).protocol === location.protocol) link.href = href;
  else link.hidden = true;
}

const came = left();
const here = location.href.split("#")[0];
const place = came ? came.reports.indexOf(here) : -1;
if (place >= 0) {
  point("among-class", came.index);
  point("among-before", came.reports[place - 1]);
  point("among-after", came.reports[place + 1]);
  document.getElementById("among-place").textContent = `${place + 1} of ${came.reports.length}`;
  document.getElementById("among").hidden = false;
}
