// Puts the page together.
import { COLOR_MAPS, css, rampOf, statusRamp } from "./color_maps.mjs";
import { readCompressed } from "./compressed.mjs";
import { control } from "./controls.mjs";
import { grouped, parse, pointCount, pointsHave, short } from "./numbers.mjs";
import { drawOverlay } from "./overlay.mjs";
import { fillHeader, fillNotes, fillPoint, fillStatuses, fillSummary, make, swatchOf, titleOf } from "./panels.mjs";
import { follow } from "./following.mjs";
import { pickPoint } from "./picking.mjs";
import { RangeControl } from "./range.mjs";
import { HALF_VALUES, readPoints, readReport, takeBytes } from "./report_file.mjs";
import { CloudScene } from "./scene.mjs";
import { Turntable, VIEWS } from "./camera.mjs";

const find = (id) => document.getElementById(id);

class Page {
  constructor() {
    Object.assign(this, { chosen: -1, hidden: new Set(), radiusFactor: 1 });
    this.range = new RangeControl(() => this.#color());
  }

  /** Shows a report, in the place of the one before if there was one: what is seen from where, the menus, the ranges that
   * somebody has set, hidden statuses and the chosen point stay as they are. */
  show(report, points) {
    const before = this.report;
    const chosenIndex = this.chosen < 0 ? -1 : this.points.indices[this.chosen];
    Object.assign(this, { report, points });
    setEmpty(false);
    fillHeader(report);
    fillSummary(report);
    fillNotes(report, points);
    fillStatuses(report, this.hidden, (status, isShown) => this.#toggle(status, isShown));
    if (before) {
      this.turntable.setCloud(points.somePlaces(), report.largestRadius, report.up);
      this.#keepRanges(before);
    } else {
      this.turntable = new Turntable(points.somePlaces(), report.largestRadius, report.up, report.pose);
      this.#startScene();
      this.#fillMenus();
      this.#listen();
    }
    this.scene?.setPoints(points);
    this.scene?.setShown((i) => this.#isShown(i));
    this.#fillQuantities(before);
    this.#chooseQuantity();
    if (!before) {
      new ResizeObserver(() => this.#resize()).observe(find("view"));
      this.#resize();
    }
    if (chosenIndex >= 0) this.#choose(points.find(chosenIndex), "The point that was chosen is no longer there.");
    this.#redraw();
  }

  /** Shows what has come since of the points. */
  grow() {
    this.turntable.setCloud(this.points.somePlaces(), this.report.largestRadius, this.report.up);
    this.scene?.grow();
    if (this.quantity) this.range.setQuantity(this.quantity, this.#codes());
    this.#overlay();
  }

  #startScene() {
    try {
      this.scene = new CloudScene(find("canvas"), this.turntable);
    } catch (error) {
      this.failure = "The cloud cannot be drawn: this browser offers no WebGL 2 with pictures of half floats " +
        `(${error.message}).`;
      return;
    }
    this.scene.onPicture = (drawn) => this.#tellPicture(drawn);
  }

  /** Notes what is drawn, and when some and all points were first, in milliseconds, as attributes of the page. */
  #tellPicture(drawn) {
    const { dataset } = document.documentElement;
    dataset.picture ??= Math.round(performance.now());
    const { points, report } = this;
    const isComplete = points.count === report.shown;
    if (drawn !== "some" && isComplete) {
      dataset.ready ??= Math.round(performance.now());
      dataset.generation = report.generation ?? 1;
    }
    find("progress").textContent = !isComplete ? `${grouped(points.count)} of ${pointCount(report.shown)} have come …`
      : dataset.ready ? "" : `Drawing ${pointCount(points.count)} …`;
    dataset.drawn = isComplete ? drawn : "some";
  }

  /** Fills the menu of quantities; what was chosen stays if it is there. */
  #fillQuantities(before) {
    const { report, points } = this;
    const menu = find("quantity");
    const wanted = before?.quantities[menu.value]?.column ?? (before ? menu.value : report.quantity);
    menu.replaceChildren(...report.quantities.map((one, q) => make("option", one.title, { value: q })));
    if (points.arrays.status) menu.append(make("option", "Status", { value: "status" }));
    if (menu.options.length === 0) menu.append(make("option", "none", { value: "none" }));
    const asked = report.quantities.findIndex(({ column }) => column === wanted);
    if (asked >= 0) menu.value = String(asked);
    if (wanted === "status" && points.arrays.status) menu.value = "status";
  }

  /** Ranges that somebody has set hold for the same columns of the next report. */
  #keepRanges(before) {
    for (const quantity of this.report.quantities) {
      const old = before.quantities.find(({ column }) => column === quantity.column);
      if (!old?.range || old.isFull || (old.range[0] === old.low && old.range[1] === old.high)) continue;
      quantity.range = old.range;
    }
  }

  #fillMenus() {
    for (const map of COLOR_MAPS) {
      find("colormap").append(make("option", map.name, { value: map.id }));
    }
    for (const [name, pose] of Object.entries(VIEWS)) {
      const button = make("button", name, { type: "button" });
      button.addEventListener("click", () => {
        this.turntable.show(pose);
        this.#redraw();
      });
      find("views").append(button);
    }
  }

  #listen() {
    find("quantity").addEventListener("change", () => this.#chooseQuantity());
    find("colormap").addEventListener("change", () => {
      this.mapId = find("colormap").value;
      this.#color();
    });
    find("splats").addEventListener("input", () => {
      this.radiusFactor = 2 ** Number(find("splats").value);
      this.scene?.setRadiusFactor(this.radiusFactor);
    });
    find("goto").addEventListener("submit", (event) => {
      event.preventDefault();
      this.#goTo(parse(find("index").value.replace(/[,\s]/g, "")));
    });
    if (this.scene) control(find("canvas"), this.turntable, () => this.#redraw(), (x, y) => this.#pick(x, y));
  }

  #isShown(i) {
    return !this.hidden.has(this.points.status(i));
  }

  #pick(x, y) {
    const isShown = (i) => this.#isShown(i);
    this.#choose(pickPoint(this.points, this.turntable, this.radiusFactor, isShown, x, y), "There is no point.");
  }

  /** Shows the point with that index in the file. */
  #goTo(index) {
    const { points, report } = this;
    if (!Number.isInteger(index) || index < 0 || index >= report.points) {
      return this.#choose(-1, `The index must be a whole number from 0 to ${grouped(report.points - 1)}.`);
    }
    const i = points.find(index);
    if (i >= 0 && points.isSomewhere(i)) {
      this.turntable.face(points.normal(i) ?? this.turntable.axes().toward.toArray(), points.place(i));
      this.#redraw();
    }
    return this.#choose(i, `Point ${grouped(index)} is none of those that the page holds.`);
  }

  #choose(i, missing) {
    this.chosen = i;
    fillPoint(this.report, this.points, i, missing);
    this.#overlay();
  }

  #toggle(status, isShown) {
    if (isShown) this.hidden.delete(status);
    else this.hidden.add(status);
    this.scene?.setShown((i) => this.#isShown(i));
  }

  #chooseQuantity() {
    const { points, report } = this;
    const value = find("quantity").value;
    this.quantity = report.quantities[value];
    find("range").hidden = !this.quantity;
    find("colormap").disabled = !this.quantity;
    if (this.quantity) {
      const codes = points.arrays[`quantity${value}`];
      this.range.setQuantity(this.quantity, this.#codes());
      this.scene?.setValues((i) => HALF_VALUES[codes[i]]);
    } else {
      this.scene?.setValues((i) => points.status(i) ?? NaN);
    }
    this.#color();
    this.#tellCoverage();
  }

  /** The codes of the chosen quantity, of the points that are here. */
  #codes() {
    return this.points.arrays[`quantity${find("quantity").value}`].subarray(0, this.points.count);
  }

  #map() {
    const fitting = COLOR_MAPS.find((map) => map.diverges === this.quantity.signed);
    return COLOR_MAPS.find((map) => map.id === this.mapId) ?? fitting;
  }

  #color() {
    if (!this.quantity) {
      this.scene?.setColors(-0.5, 255.5, statusRamp());
      this.#fillStatusLegend();
      return;
    }
    const map = this.#map();
    find("colormap").value = map.id;
    this.range.setMap(map);
    const [low, high] = this.quantity.range;
    this.scene?.setColors(low / this.quantity.scale, high / this.quantity.scale, rampOf(map, low, high));
    this.#fillLegend(rampOf(map, low, high), low, high);
  }

  #fillStatusLegend() {
    const lines = this.report.statuses.map(({ value, word }) => {
      const line = make("div", undefined, { class: "status" });
      line.append(swatchOf(value), make("span", word));
      return line;
    });
    find("legend").replaceChildren(make("b", lines.length > 0 ? "Status" : "No quantity"), ...lines);
  }

  #fillLegend(ramp, low, high) {
    const stops = Array.from({ length: 17 }, (_, stop) => {
      const at = 4 * Math.round((stop / 16) * 255);
      return css(ramp.subarray(at, at + 3));
    });
    const bar = make("div", undefined, { class: "bar" });
    bar.style.background = `linear-gradient(to right, ${stops.join(", ")})`;
    const ends = make("div", undefined, { class: "ends" });
    ends.append(make("span", short(low, 3)));
    if (low < 0 && high > 0 && low === -high) ends.append(make("span", "0"));
    ends.append(make("span", short(high, 3)));
    find("legend").replaceChildren(make("b", titleOf(this.quantity, this.report)), bar, ends);
  }

  #tellCoverage() {
    const { quantity, report } = this;
    const without = quantity ? report.points - quantity.finite : 0;
    find("coverage").textContent = !quantity ? ""
      : without === 0 ? "Every point has a value."
        : `${pointsHave(without)} no value, of ${grouped(report.points)}: grey in the picture.`;
  }

  #redraw() {
    this.scene?.draw();
    this.#overlay();
  }

  #overlay() {
    drawOverlay(find("overlay"), this.turntable, this.points, this.chosen);
  }

  #resize() {
    const { clientWidth, clientHeight } = find("view");
    if (clientWidth === 0 || clientHeight === 0) return;
    this.scene?.resize(clientWidth, clientHeight);
    this.#overlay();
  }
}

/** Whether there is nothing to choose or to read so far, beside the word of what is going on. */
function setEmpty(isEmpty) {
  document.documentElement.toggleAttribute("data-empty", isEmpty);
}

function tell(message) {
  find("progress").textContent = message;
  find("progress").classList.remove("bad");
  delete document.documentElement.dataset.failed;
}

function fail(message) {
  find("progress").textContent = message;
  find("progress").classList.add("bad");
  document.documentElement.dataset.failed = message;
}

/** Resolves to the report that the page holds, and its points. */
async function unpack(report) {
  fillHeader(report);
  setEmpty(Boolean(report.laz));
  if (report.laz) return readCompressed(report, takeBytes(), tell);
  fillSummary(report);
  try {
    return { report, points: await readPoints(report) };
  } catch (error) {
    throw new Error(`The points cannot be unpacked: ${error.message}`, { cause: error });
  }
}

/** Shows the report that the page holds. */
async function showReport(page, written) {
  try {
    const { report, points } = await unpack(written);
    page.show(report, points);
  } catch (error) {
    return fail(error.message);
  }
  if (page.failure) fail(page.failure);
}

const report = readReport();
if (report.served) {
  setEmpty(true);
  follow(new Page(), { tell, fail });
} else {
  showReport(new Page(), report);
}
