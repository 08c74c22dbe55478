// What lies over the cloud: where the axes point, how long a length is, and the chosen point with its directions.

import { short } from "./numbers.mjs";

const SVG = "http://www.w3.org/2000/svg";
const AXIS_COLORS = { x: "#c8372d", y: "#2f8f3a", z: "#2f6fd0" };

function element(name, attributes, text) {
  const made = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  if (text !== undefined) made.textContent = text;
  return made;
}

/** The axes at the lower left: those that point away are thin. */
function drawAxes(overlay, turntable, height) {
  const [x, y, length] = [46, height - 46, 28];
  const { right, up, toward } = turntable.axes();
  const axes = ["x", "y", "z"].map((name, i) => ({
    name, across: right.getComponent(i), above: up.getComponent(i), depth: toward.getComponent(i),
  }));
  const group = element("g", { id: "axes" });
  for (const { name, across, above, depth } of axes.sort((a, b) => a.depth - b.depth)) {
    const end = [x + length * across, y - length * above];
    const color = AXIS_COLORS[name];
    group.append(
      element("line", { x1: x, y1: y, x2: end[0], y2: end[1], stroke: color, "stroke-width": depth < -0.1 ? 1.5 : 3,
        "stroke-linecap": "round" }),
      element("text", { x: x + (length + 11) * across - (Math.hypot(across, above) < 0.3 ? -9 : 0),
        y: y - (length + 11) * above + 5, "text-anchor": "middle" }, name),
    );
  }
  overlay.append(group);
}

/** One digit and zeros, as a power of ten where those are many. */
const roundText = (length) =>
  length >= 1e-3 && length < 1e5 ? String(Number(length.toPrecision(1))) : short(length, 1);

/** A bar as long as a round length of the file. */
function drawScale(overlay, turntable, points, unit, height) {
  if (points.sides.every((side) => side === 0)) return;
  const pixels = turntable.pixelsPerUnit() / points.unit;
  const power = 10 ** Math.floor(Math.log10(120 / pixels));
  const length = power * [5, 2, 1].find((factor) => factor * power * pixels <= 120);
  if (!Number.isFinite(length) || !(length > 0)) return;
  const [x, y, width] = [100, height - 24, length * pixels];
  overlay.append(
    element("path", { d: `M${x} ${y - 5}v5h${width}v-5`, fill: "none", stroke: "currentColor", "stroke-width": 2 }),
    element("text", { x: x + width / 2, y: y - 8, "text-anchor": "middle" },
      `${roundText(length)}${unit ? ` ${unit}` : ""}`),
  );
}

/** A ring around the point, and a line through it along each of its directions. */
function drawMarker(overlay, turntable, points, chosen, [x, y]) {
  const length = 42 / turntable.pixelsPerUnit();
  const directions = points.directions(chosen);
  const place = points.place(chosen);
  const [across, above] = turntable.project(place);
  const middle = [x + across, y - above];
  const labels = [];
  for (const [d, direction] of (directions ?? []).entries()) {
    const ends = [length, -length].map((way) => {
      const [right, up] = turntable.project(place.map((c, axis) => c + way * direction[axis]));
      return [right + x, y - up];
    });
    const [[x2, y2], [x1, y1]] = ends;
    const name = d === 0 ? "first" : "second";
    // Where both lines look alike, their names stand at opposite ends.
    const apart = (end) => Math.min(...labels.map((label) => Math.hypot(label[0] - end[0], label[1] - end[1])));
    const end = labels.length > 0 && apart(ends[1]) > apart(ends[0]) ? ends[1] : ends[0];
    labels.push(end);
    overlay.append(
      element("line", { x1, y1, x2, y2, stroke: "var(--scene)", "stroke-width": 6, "stroke-linecap": "round" }),
      element("line", { id: `direction-${d + 1}`, x1, y1, x2, y2, stroke: `var(--${name})`, "stroke-width": 3,
        "stroke-linecap": "round" }),
      element("text", { x: end[0] + Math.sign(end[0] - middle[0]) * 11,
        y: end[1] + Math.sign(end[1] - middle[1]) * 7 + 5, "text-anchor": "middle" }, `d${"₁₂"[d]}`),
    );
  }
  const ring = { cx: middle[0], cy: middle[1], fill: "none" };
  overlay.append(element("circle", { ...ring, r: 7, stroke: "var(--scene)", "stroke-width": 5 }),
                 element("circle", { ...ring, r: 7, id: "marker", stroke: "var(--ink)", "stroke-width": 2 }));
}

/** Draws it all again. `chosen` is a point as the report counts, or -1. */
export function drawOverlay(overlay, turntable, points, chosen) {
  const { width, height } = turntable;
  overlay.setAttribute("viewBox", `0 0 ${width} ${height}`);
  overlay.replaceChildren();
  const middle = [width / 2, height / 2];
  if (chosen >= 0 && points.isSomewhere(chosen)) drawMarker(overlay, turntable, points, chosen, middle);
  drawAxes(overlay, turntable, height);
  drawScale(overlay, turntable, points, points.report.unit, height);
}
