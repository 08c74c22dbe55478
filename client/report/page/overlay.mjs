// What lies over the cloud: where the axes point, how long a length is, and the chosen point with its directions.

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

/** A bar as long as a round length of the file. */
function drawScale(overlay, turntable, points, unit, height, short) {
  const pixels = turntable.pixelsPerUnit() / points.unit;
  const power = 10 ** Math.floor(Math.log10(120 / pixels));
  const length = power * [5, 2, 1].find((factor) => factor * power * pixels <= 120);
  if (!Number.isFinite(length) || !(length > 0)) return;
  const [x, y, width] = [100, height - 24, length * pixels];
  overlay.append(
    element("path", { d: `M${x} ${y - 5}v5h${width}v-5`, fill: "none", stroke: "currentColor", "stroke-width": 2 }),
    element("text", { x: x + width / 2, y: y - 8, "text-anchor": "middle" },
      `${short(length, 1)}${unit ? ` ${unit}` : ""}`),
  );
}

/** A ring around the point, and a line through it along each of its directions. */
function drawMarker(overlay, turntable, points, chosen, [x, y]) {
  const length = 42 / turntable.pixelsPerUnit();
  const directions = points.directions(chosen);
  const place = points.place(chosen);
  for (const [d, direction] of (directions ?? []).entries()) {
    const [from, to] = [-length, length].map((way) =>
      turntable.project(place.map((c, axis) => c + way * direction[axis])));
    const [x1, y1, x2, y2] = [from[0] + x, y - from[1], to[0] + x, y - to[1]];
    const name = d === 0 ? "first" : "second";
    overlay.append(
      element("line", { x1, y1, x2, y2, stroke: "var(--scene)", "stroke-width": 6, "stroke-linecap": "round" }),
      element("line", { id: `direction-${d + 1}`, x1, y1, x2, y2, stroke: `var(--${name})`, "stroke-width": 3,
        "stroke-linecap": "round" }),
      element("text", { x: x2 + Math.sign(x2 - x1) * 10, y: y2 + 5, "text-anchor": "middle" }, `d${"₁₂"[d]}`),
    );
  }
  const [across, above] = turntable.project(place);
  const ring = { cx: x + across, cy: y - above, fill: "none" };
  overlay.append(element("circle", { ...ring, r: 7, stroke: "var(--scene)", "stroke-width": 5 }),
                 element("circle", { ...ring, r: 7, id: "marker", stroke: "var(--ink)", "stroke-width": 2 }));
}

/** Draws it all again. `chosen` is a point as the report counts, or -1. */
export function drawOverlay(overlay, turntable, points, chosen, short) {
  const { width, height } = turntable;
  overlay.setAttribute("viewBox", `0 0 ${width} ${height}`);
  overlay.replaceChildren();
  if (chosen >= 0 && points.isSomewhere(chosen)) drawMarker(overlay, turntable, points, chosen, [width / 2, height / 2]);
  drawAxes(overlay, turntable, height);
  drawScale(overlay, turntable, points, points.report.unit, height, short);
}
