// Tables and texts beside the cloud. All of them are set as text, never as markup: names come from files.
import { css, statusColor } from "./color_maps.mjs";
import { grouped, pointCount, pointsHave, short, toStep, unitText } from "./numbers.mjs";

export function make(name, text, attributes = {}) {
  const made = document.createElement(name);
  if (text !== undefined) made.textContent = text;
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  return made;
}

const find = (id) => document.getElementById(id);
const row = (...cells) => {
  const made = make("tr");
  made.append(...cells);
  return made;
};

/** A title with its unit: "Mean curvature H (1/mm)". */
export function titleOf(quantity, report) {
  const unit = unitText(quantity.exponent, report.unit);
  return unit ? `${quantity.title} (${unit})` : quantity.title;
}

export function fillHeader(report) {
  document.title = `${report.title}: curvature`;
  find("title").textContent = report.title;
  const thinned = report.shown < report.points;
  find("subtitle").textContent = thinned
    ? `${pointCount(report.points)}, of which ${grouped(report.shown)} are shown`
    : pointCount(report.points);
}

function table(caption, heads, rows) {
  const made = make("table", undefined, heads.length > 4 ? { class: "many" } : {});
  made.append(make("caption", caption));
  const head = make("thead");
  head.append(row(...heads.map((text) => make("th", text, { scope: "col" }))));
  const body = make("tbody");
  body.append(...rows);
  made.append(head, body);
  const wide = make("div", undefined, { class: "wide", tabindex: "0", role: "region", "aria-label": caption });
  wide.append(made);
  return wide;
}

const percentHead = (percent) => ({ 0: "least", 50: "median", 100: "largest" })[percent] ?? `${percent} %`;

export function fillSummary(report) {
  const number = (value, digits) => make("td", value === null ? "none" : short(value, digits));
  const quantities = report.quantities.map((quantity) =>
    row(make("th", titleOf(quantity, report), { scope: "row" }), make("td", grouped(quantity.finite)),
        ...quantity.percentiles.map((value) => number(value, 4))));
  const box = ["x", "y", "z"].map((name, axis) =>
    row(make("th", name, { scope: "row" }), number(report.low[axis], 7), number(report.high[axis], 7),
        number(report.high[axis] - report.low[axis], 5)));
  const unit = report.unit ? ` (${report.unit})` : "";
  const tables = [table(`Bounding box${unit}`, ["axis", "from", "to", "length"], box)];
  if (quantities.length > 0) {
    tables.unshift(table("Values of all points of the file that have one",
                         ["quantity", "points", ...report.percents.map(percentHead)], quantities));
  }
  find("summary").replaceChildren(...tables);
}

export function swatchOf(status) {
  const swatch = make("span", undefined, { class: "swatch" });
  swatch.style.background = css(statusColor(status));
  return swatch;
}

/** A checkbox for each status, empty for those that are `hidden`; calls `changed(status, isShown)`. */
export function fillStatuses(report, hidden, changed) {
  find("status-note").textContent = "";
  if (report.statuses.length === 0) {
    find("statuses").replaceChildren(make("li", "The file has no column of statuses."));
    return;
  }
  find("statuses").replaceChildren(...report.statuses.map(({ value, word, count }) => {
    const item = make("li"), label = make("label");
    const box = make("input", undefined, { type: "checkbox", id: `status-${value}` });
    box.checked = !hidden.has(value);
    box.addEventListener("change", () => changed(value, box.checked));
    label.append(box, swatchOf(value), make("span", word), make("span", grouped(count), { class: "count" }));
    item.append(label);
    return item;
  }));
  const without = report.points - (report.statuses.find(({ value }) => value === 1)?.count ?? 0);
  find("status-note").textContent = without === 0 ? "Every point has a curvature."
    : `${pointsHave(without)} a status other than ok, and no curvature: grey, not zero.`;
}

export function fillNotes(report, points) {
  const step = points.unit * Math.max(...points.extent) / 131068;
  const length = report.unit || "the file's length unit";
  const notes = [
    `Lengths are in ${length}; mean and principal curvatures in 1/length, Gaussian curvature in 1/length². A ball ` +
      "of radius r has H = 1/r, G = 1/r², k₁ = k₂ = 1/r.",
    "The page keeps values to 0.05 % of themselves (binary16), positions to " +
      `${short(step, 2)} ${report.unit || "length units"} along each axis, normals and directions to 0.7°. The summary ` +
      "was computed from the file's own numbers.",
  ];
  if (report.shown < report.points) {
    notes.push(`The file has ${grouped(report.points)} points. The page shows ${grouped(report.shown)} of them, ` +
      "chosen by a hash of their index, evenly over the file; the summary counts all.");
  }
  if (report.unplaced > 0) {
    notes.push(`${pointsHave(report.unplaced)} no finite position: counted, but not drawn.`);
  }
  if (report.leftOut.length > 0) notes.push(`Columns that are left out: ${report.leftOut.join(", ")}.`);
  if (!points.arrays.normal_u) notes.push("The file has no normals: splats face the viewer.");
  find("notes").replaceChildren(...[...notes, ...report.notes].map((text) => make("li", text)));
}

/** Everything about one point, `i` as the report counts; or why there is nothing to tell. */
export function fillPoint(report, points, i, missing) {
  const place = find("point");
  if (i < 0) return place.replaceChildren(make("p", missing));
  const rows = [];
  const add = (name, text, style = "") =>
    rows.push(row(make("th", name, { scope: "row" }), make("td", text, style ? { class: style } : {})));
  const vector = (v, step) => v.map((c) => toStep(c, step)).join(", ");
  const status = points.status(i);
  add("Index", grouped(points.indices[i]));
  const side = Math.max(...points.sides);
  add("Position", points.isSomewhere(i) ? vector(points.position(i), side / 65534) : "not finite");
  const known = report.statuses.find(({ value }) => value === status);
  if (status !== null) add("Status", known.word, status === 1 ? "" : "bad");
  for (const [q, quantity] of report.quantities.entries()) {
    const value = points.value(q, i);
    const unit = unitText(quantity.exponent, report.unit);
    add(quantity.title, Number.isNaN(value) ? "none" : `${short(value)} ${unit}`, Number.isNaN(value) ? "bad" : "");
  }
  const directions = points.directions(i);
  if (directions) {
    for (const [d, direction] of directions.entries()) {
      add(`Direction d${"₁₂"[d]}`, vector(direction, 0.01), ["first", "second"][d]);
    }
  }
  const normal = points.normal(i);
  if (normal) add("Normal", vector(normal, 0.01));
  const made = make("table");
  made.append(...rows);
  place.replaceChildren(made);
}
