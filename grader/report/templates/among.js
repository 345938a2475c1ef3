"use strict";
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
