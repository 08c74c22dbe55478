#!/usr/bin/python3
"""Puts renders together into figures with one color scale for each row: pictures.py RENDERS FOLDER

RENDERS holds the panels and panels.csv of renders.sh."""
import collections
import csv
import math
import pathlib
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize, TwoSlopeNorm
from PIL import Image, ImageChops

PAGE = 7.2
DPI = 200
COLUMNS = {"exact": "exact", "jet-2": "jet, degree 2", "jet-4": "jet, degree 4", "aso": "ASO",
           "uniform-100": "uniform, L = 100", "uniform-200": "uniform, L = 200", "hexagram": "hexagram",
           "avg-hexagram": "avg-hexagram"}
QUANTITIES = {"mean": "H", "gaussian": "G", "k1": "k1", "k2": "k2"}
plt.rcParams.update({"font.size": 7, "font.family": "DejaVu Sans", "axes.linewidth": 0.5})

Panel = collections.namedtuple("Panel", "row column low high source image")


def load(folder, figure):
    """The panels of a figure in the order they were rendered, each without its own scale."""
    panels = []
    with open(folder / "panels.csv", newline="") as file:
        for line in csv.DictReader(file):
            if line["figure"] != figure:
                continue
            image = Image.open(folder / f"{figure}__{line['row']}__{line['column']}.png").convert("RGB")
            letters = max(11.0, 0.0215 * min(image.height, 0.85 * image.width))
            scale = math.ceil(11.5 * letters)  # client/render/legend.cc
            image = image.crop((0, 0, image.width - scale, image.height))
            panels.append(Panel(line["row"], line["column"], float(line["low"]), float(line["high"]), line["source"],
                                image))
    return panels


def color_bar(figure, place, low, high, label=None):
    """The client's scale: zero, where it is inside, is the middle of the map (Moreland 2009)."""
    norm = TwoSlopeNorm(0.0, low, high) if low < 0.0 < high else Normalize(low, high)
    bar = figure.colorbar(ScalarMappable(norm, "coolwarm"), cax=figure.add_axes(place))
    ticks = sorted({low, 0.0, high} if low < 0.0 < high else {low, high})
    bar.set_ticks(ticks, labels=[f"{tick:g}" for tick in ticks])
    bar.ax.minorticks_off()
    bar.ax.tick_params(length=2, width=0.5, labelsize=6)
    if label:
        bar.ax.set_title(label, fontsize=7)


def show(figure, image, place, title=None):
    axes = figure.add_axes(place)
    axes.imshow(image, interpolation="lanczos")
    axes.set_axis_off()
    if title:
        axes.set_title(title, fontsize=7, pad=2)


def save(figure, path):
    figure.savefig(path, dpi=DPI)
    plt.close(figure)
    # 256 colors, dithered, take a third of the bytes and show no bands.
    image = Image.open(path).convert("RGB")
    palette = image.quantize(255)
    palette.putpalette(palette.getpalette()[:3 * 255] + [255, 255, 255])
    reduced = image.quantize(palette=palette, dither=Image.Dither.FLOYDSTEINBERG)
    # Paper stays white, not the nearest of the other colors.
    reduced.paste(255, mask=image.convert("L").point(lambda value: 255 * (value == 255)))
    reduced.save(path, optimize=True)


def trim(panels):
    """The panels of one row without the blank above and below that all of them have."""
    boxes = [ImageChops.invert(panel.image.convert("L")).getbbox() for panel in panels]
    top, bottom = min(box[1] for box in boxes), max(box[3] for box in boxes)
    return [panel._replace(image=panel.image.crop((0, top, panel.image.width, bottom))) for panel in panels]


def comparison(panels, row_names, path):
    """Methods beside each other, a row for each quantity and cloud."""
    rows = [trim([panel for panel in panels if panel.row == row]) for row in dict.fromkeys(p.row for p in panels)]
    left, right, top, gap = 0.55, 0.55, 0.2, 0.06  # inches
    cell = (PAGE - left - right) / max(len(row) for row in rows)
    heights = [cell * row[0].image.height / row[0].image.width for row in rows]
    height = top + sum(heights) + gap * len(rows)
    figure = plt.figure(figsize=(PAGE, height))
    bottom = height - top
    for i, (row, row_height) in enumerate(zip(rows, heights)):
        bottom -= row_height
        for j, panel in enumerate(row):
            place = ((left + j * cell) / PAGE, bottom / height, cell / PAGE, row_height / height)
            show(figure, panel.image, place, COLUMNS[panel.column] if i == 0 else None)
        figure.text(0.01, (bottom + 0.5 * row_height) / height, row_names(row[0].row), va="center", fontsize=7)
        color_bar(figure, (1 - 0.5 / PAGE, (bottom + 0.14 * row_height) / height, 0.08 / PAGE,
                           0.72 * row_height / height), row[0].low, row[0].high)
        bottom -= gap
    save(figure, path)


def gallery(panels, columns, names, path, one_scale):
    """Renders of one cloud, with a color scale each or one for all."""
    rows = math.ceil(len(panels) / columns)
    top, scale = 0.18, 0.5
    cell = (PAGE - scale * (1 if one_scale else columns)) / columns
    pitch = cell if one_scale else cell + scale
    height = rows * (cell + top)
    figure = plt.figure(figsize=(PAGE, height))
    for index, panel in enumerate(panels):
        i, j = divmod(index, columns)
        bottom = 1 - ((i + 1) * (cell + top)) / height
        show(figure, panel.image, (j * pitch / PAGE, bottom, cell / PAGE, cell / height), names(panel.column))
        if not one_scale:
            color_bar(figure, ((j * pitch + cell) / PAGE, bottom + 0.2 * cell / height, 0.08 / PAGE,
                               0.6 * cell / height), panel.low, panel.high)
    if one_scale:
        color_bar(figure, (1 - 0.42 / PAGE, 0.3, 0.08 / PAGE, 0.4), panels[0].low, panels[0].high, "H")
    save(figure, path)


def figure6_row(row):
    noise, quantity = row.split("-")
    return f"{QUANTITIES[quantity]}\n" + ("no noise" if noise == "0" else f"noise {noise}")


def supplement_row(row):
    kind, quantity = row.split("-")
    return f"{QUANTITIES[quantity]}\n{kind}"


def main():
    renders, folder = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
    comparison(load(renders, "figure6"), figure6_row, folder / "figure6.png")
    for surface in ("goursat", "torus"):
        comparison(load(renders, f"supplement-{surface}"), supplement_row, folder / f"supplement-{surface}.png")
    gallery(load(renders, "figure7"), 2, lambda name: {"mean": "mean curvature H", "gaussian": "Gaussian curvature G"}
            .get(name, f"principal curvature {name}"), folder / "figure7.png", one_scale=False)
    gallery(load(renders, "figure8"), 3, lambda name: f"K = {name}", folder / "figure8.png", one_scale=True)
    gallery(load(renders, "automatic"), 2, lambda name: {"chosen": "chosen K", "auto": "H, auto"}
            .get(name, f"H, avg-hexagram, K = {name}"), folder / "automatic-scan.png", one_scale=False)


if __name__ == "__main__":
    main()
