// Puts the page together.
import { COLOR_MAPS, css, rampOf, statusRamp } from "./color_maps.mjs";
import { control } from "./controls.mjs";
import { grouped, parse, pointCount, pointsHave, short } from "./numbers.mjs";
import { drawOverlay } from "./overlay.mjs";
import { fillHeader, fillNotes, fillPoint, fillStatuses, fillSummary, make, swatchOf, titleOf } from "./panels.mjs";
import { pickPoint } from "./picking.mjs";
import { RangeControl } from "./range.mjs";
import { HALF_VALUES, readPoints, readReport } from "./report_file.mjs";
import { CloudScene } from "./scene.mjs";
import { Turntable, VIEWS } from "./camera.mjs";

const find = (id) => document.getElementById(id);

class Page {
  constructor(report, points) {
    Object.assign(this, { report, points, chosen: -1, hidden: new Set(), radiusFactor: 1 });
    this.turntable = new Turntable(points.somePlaces(), report.largestRadius, report.up, report.pose);
    this.range = new RangeControl(() => this.#color());
    fillStatuses(report, (status, isShown) => this.#toggle(status, isShown));
    fillNotes(report, points);
    this.#startScene();
    this.#fillMenus();
    this.#listen();
    this.#chooseQuantity();
    new ResizeObserver(() => this.#resize()).observe(find("view"));
    this.#resize();
  }

  #startScene() {
    try {
      this.scene = new CloudScene(find("canvas"), this.points, this.turntable);
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
    if (drawn !== "some") dataset.ready ??= Math.round(performance.now());
    find("progress").textContent = dataset.ready ? "" : `Drawing ${pointCount(this.points.count)} …`;
    dataset.drawn = drawn;
  }

  #fillMenus() {
    const quantity = find("quantity");
    for (const [q, one] of this.report.quantities.entries()) quantity.append(make("option", one.title, { value: q }));
    if (this.points.arrays.status) quantity.append(make("option", "Status", { value: "status" }));
    const asked = this.report.quantities.findIndex(({ column }) => column === this.report.quantity);
    if (asked >= 0) quantity.value = String(asked);
    if (this.report.quantity === "status" && this.points.arrays.status) quantity.value = "status";
    if (quantity.options.length === 0) quantity.append(make("option", "none", { value: "none" }));
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
    // The indices ascend.
    let [low, high] = [0, points.count];
    while (low < high) {
      const middle = (low + high) >> 1;
      if (points.indices[middle] < index) low = middle + 1;
      else high = middle;
    }
    const isHeld = points.indices[low] === index;
    if (isHeld && points.isSomewhere(low)) {
      this.turntable.face(points.normal(low) ?? this.turntable.axes().toward.toArray(), points.place(low));
      this.#redraw();
    }
    return this.#choose(isHeld ? low : -1, `Point ${grouped(index)} is none of those that the page holds.`);
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
      this.range.setQuantity(this.quantity, codes);
      this.scene?.setValues((i) => HALF_VALUES[codes[i]]);
    } else {
      this.scene?.setValues((i) => points.status(i) ?? NaN);
    }
    this.#color();
    this.#tellCoverage();
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

function fail(message) {
  find("progress").textContent = message;
  find("progress").classList.add("bad");
  document.documentElement.dataset.failed = message;
}

const report = readReport();
fillHeader(report);
fillSummary(report);
readPoints(report).then((points) => {
  const page = new Page(report, points);
  if (page.failure) fail(page.failure);
}, (error) => fail(`The points cannot be unpacked: ${error.message}`));
