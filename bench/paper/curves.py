#!/usr/bin/python3
"""Draws errors and times against K and N: curves.py RESULTS FOLDER

RESULTS holds errors.csv and times.csv of paper_errors and paper_times; the figures go to FOLDER as SVG, and the
errors, averaged over realizations, as errors.csv.gz beside times.csv."""
import math
import pathlib
import shutil
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

import results

PAGE = 7.2  # inches
MAIN = ("avg-hexagram R=1", "avg-hexagram R=2", "hexagram", "uniform L=100", "independent L=100", "delaunay even",
        "delaunay", "jet degree 2", "jet degree 4", "aso")
NAMES = {"H": "mean curvature H", "G": "Gaussian curvature G"}
plt.rcParams.update({
    "font.size": 8, "axes.labelsize": 8, "axes.titlesize": 8, "legend.fontsize": 7.5, "lines.linewidth": 1.1,
    "lines.markersize": 3.2, "axes.linewidth": 0.6, "xtick.labelsize": 7, "ytick.labelsize": 7,
    "font.family": "DejaVu Sans", "svg.hashsalt": "curvd"})


def noise_name(noise):
    """Standard deviations: position / normal."""
    return "no noise" if noise == (0, 0) else f"noise {noise[0]:g} / {noise[1]:g}"


def plot_method(axes, method, x, y, low=None, high=None, line=None):
    color, style, marker, name = results.STYLES[method]
    axes.plot(x, y, color=color, linestyle=line or style, marker=marker, markerfacecolor="white" if marker else None,
              markeredgewidth=0.8, label=name)
    if low is not None:
        axes.fill_between(x, low, high, color=color, alpha=0.18, linewidth=0)


def log_axes(axes, x_ticks):
    axes.set_xscale("log")
    axes.set_yscale("log")
    low, high = axes.get_ylim()
    # Every panel has at least three numbers on its axis, and none so many that they touch.
    axes.yaxis.set_major_locator(LogLocator(subs=(1,) if high > 300 * low else (1, 2, 5)))
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.yaxis.set_minor_formatter(NullFormatter())
    axes.set_xticks(x_ticks)
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.xaxis.set_minor_locator(LogLocator(subs=()))
    axes.grid(True, which="major", linewidth=0.4, color="#d0d0d0")
    axes.grid(True, which="minor", linewidth=0.2, color="#e8e8e8")
    axes.set_axisbelow(True)


def legend_below(figure, axes, columns=5):
    handles, labels = axes.get_legend_handles_labels()
    rows = -(-len(labels) // columns)
    height = figure.get_figheight()
    figure.tight_layout(rect=(0, (0.08 + 0.17 * rows) / height, 1, 1), h_pad=0.8, w_pad=0.6)
    figure.legend(handles, labels, loc="lower center", ncol=columns, frameon=False, handlelength=2.6,
                  columnspacing=1.4)


def save(figure, folder, name):
    for kind in sys.argv[3:] or ["svg"]:
        # Without a date, the same figures give the same file.
        figure.savefig(folder / f"{name}.{kind}", metadata={"Date": None} if kind == "svg" else None, dpi=130)
    plt.close(figure)


def draw_errors(axes, rows, quantity, x_name, methods=MAIN):
    """Mean errors against K or N; the band is from the least to the greatest realization."""
    for method in methods:
        points = sorted(results.select(rows, method=method), key=lambda row: row[x_name])
        # With K below its number of coefficients, a fit has no values.
        points = [row for row in points if row["failed"] < 0.5]
        if points:
            column = lambda name: [row[name] for row in points]
            plot_method(axes, method, column(x_name), column(f"{quantity}_mae"), column(f"{quantity}_mae_low"),
                        column(f"{quantity}_mae_high"))


def error_panels(grid_rows, grid_columns, height):
    return plt.subplots(grid_rows, grid_columns, figsize=(PAGE, height), squeeze=False, sharex=True)


def middle_size(rows):
    sizes = sorted({row["N"] for row in results.select(rows, sampling="even")})
    return 25_000 if 25_000 in sizes else sizes[0]


def levels(rows):
    return sorted({row["position_noise"] for row in rows})


def errors_over_k(rows, surface, folder):
    """Figure 4: both curvatures, both noises together."""
    points = middle_size(rows)
    figure, panels = error_panels(2, 3, 4.7)
    for line, quantity in zip(panels, "HG"):
        for axes, level in zip(line, levels(rows)):
            chosen = results.select(rows, surface=surface, sampling="even", N=points, position_noise=level,
                                    normal_noise=level)
            draw_errors(axes, chosen, quantity, "K")
            log_axes(axes, [10, 25, 50, 100, 200, 400])
            if quantity == "H":
                axes.set_title(noise_name((level, level)))
            else:
                axes.set_xlabel("neighbors K")
        line[0].set_ylabel(f"mean |error| of {quantity}")
    legend_below(figure, panels[0][0])
    save(figure, folder, f"figure4-{surface}")


def errors_over_noise(rows, surface, folder):
    """Figure 4 for all nine noise levels, mean curvature."""
    points = middle_size(rows)
    figure, panels = error_panels(3, 3, 6.6)
    for line, position in zip(panels, levels(rows)):
        for axes, normal in zip(line, levels(rows)):
            chosen = results.select(rows, surface=surface, sampling="even", N=points, position_noise=position,
                                    normal_noise=normal)
            draw_errors(axes, chosen, "H", "K")
            log_axes(axes, [10, 25, 50, 100, 200, 400])
            axes.set_title(noise_name((position, normal)))
        line[0].set_ylabel("mean |error| of H")
    for axes in panels[-1]:
        axes.set_xlabel("neighbors K")
    legend_below(figure, panels[0][0])
    save(figure, folder, f"figure4-noise-{surface}")


def errors_over_points(rows, surface, folder):
    """Figure 4 against the number of points."""
    even = results.select(rows, surface=surface, sampling="even")
    figure, panels = error_panels(2, 3, 4.7)
    for line, k in zip(panels, (50, 200)):
        for axes, level in zip(line, levels(rows)):
            draw_errors(axes, results.select(even, K=k, position_noise=level, normal_noise=level), "H", "N")
            # Numbers at every other size, from the largest down: neighbors would touch.
            log_axes(axes, sorted({row["N"] for row in even})[::-2])
            axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value / 1000:g}k"))
            axes.set_title(f"K = {k}, {noise_name((level, level))}")
        line[0].set_ylabel("mean |error| of H")
    for axes in panels[-1]:
        axes.set_xlabel("points N")
    legend_below(figure, panels[0][0])
    save(figure, folder, f"figure4-points-{surface}")


def errors_over_triangles(rows, folder):
    """How many random triangles it takes."""
    points = middle_size(rows)
    methods = ("uniform L=10", "uniform L=50", "uniform L=100", "uniform L=200", "independent L=100",
               "avg-hexagram R=1")
    figure, panels = error_panels(2, 3, 4.7)
    for line, surface in zip(panels, results.SURFACES):
        for axes, level in zip(line, levels(rows)):
            chosen = results.select(rows, surface=surface, sampling="even", N=points, position_noise=level,
                                    normal_noise=level)
            draw_errors(axes, chosen, "H", "K", methods)
            log_axes(axes, [10, 25, 50, 100, 200, 400])
            axes.set_title(f"{surface}, {noise_name((level, level))}", fontsize=7)
        line[0].set_ylabel("mean |error| of H")
    for axes in panels[-1]:
        axes.set_xlabel("neighbors K")
    legend_below(figure, panels[0][0], columns=3)
    save(figure, folder, "triangles")


def rotations(rows, folder):
    """Error of R rotations over that of one, over all clouds with as much noise: median, and 8 of 10 clouds."""
    even = results.select(rows, sampling="even")
    one = {tuple(row[name] for name in results.KEY[:-1]): row for row in results.select(even, method="avg-hexagram R=1")}
    figure, panels = plt.subplots(1, 2, figsize=(PAGE, 2.5), sharey=True)
    for axes, quantity in zip(panels, "HG"):
        for r, color in ((2, "#6baed6"), (3, "#2171b5"), (4, "#08306b")):
            ratios = {}
            for row in results.select(even, method=f"avg-hexagram R={r}"):
                key = tuple(row[name] for name in results.KEY[:-1])
                ratios.setdefault(row["K"], []).append(row[f"{quantity}_mae"] / one[key][f"{quantity}_mae"])
            ks = sorted(ratios)
            quantile = lambda f: [sorted(ratios[k])[int(f * (len(ratios[k]) - 1))] for k in ks]
            axes.plot(ks, quantile(0.5), color=color, marker="o", label=f"R = {r}")
            axes.fill_between(ks, quantile(0.1), quantile(0.9), color=color, alpha=0.15, linewidth=0)
        axes.axhline(1.0, color="black", linewidth=0.6)
        log_axes(axes, [10, 25, 50, 100, 200, 400])
        axes.set_yscale("linear")
        axes.set_xlabel("neighbors K")
        axes.set_title(NAMES[quantity])
    panels[0].set_ylabel("mean |error| over that of R = 1")
    legend_below(figure, panels[0])
    save(figure, folder, "rotations")


def times_over_k(rows, folder):
    """Figure 5: microseconds a point, ours and the peers'."""
    figure, panels = plt.subplots(1, 3, figsize=(PAGE, 3.4), sharey=True)
    titles = ("after the search: curvd", "after the search: peers", "index, search and estimate: curvd")
    for axes, column, title in zip(panels, ("after_search_us", "peer_after_search_us", "total_us"), titles):
        for method in MAIN:
            # A method that has no values at all takes no time that means anything.
            points = [row for row in results.select(rows, method=method)
                      if row[column] != "" and not math.isnan(row["H_mae"])]
            if points:
                plot_method(axes, method, [row["K"] for row in points], [row[column] for row in points])
        log_axes(axes, [10, 25, 50, 100, 200, 400])
        axes.set_title(title)
        axes.set_xlabel("neighbors K")
    panels[0].set_ylabel("CPU microseconds a point")
    legend_below(figure, panels[0])
    save(figure, folder, "figure5")


def non_uniform(rows, folder):
    """The supplement: errors on samples of uneven density."""
    samplings = [name for name in ("filter", "lidar", "thinned", "scanned") if results.select(rows, sampling=name)]
    titles = {"filter": "the paper's, thinned", "lidar": "the paper's, scanned", "thinned": "ours, thinned",
              "scanned": "ours, scanned"}
    figure, panels = error_panels(2, len(samplings), 4.5)
    for line, surface in zip(panels, results.SURFACES):
        for axes, sampling in zip(line, samplings):
            chosen = results.select(rows, surface=surface, sampling=sampling)
            draw_errors(axes, chosen, "H", "K")
            log_axes(axes, [10, 50, 200])
            axes.set_title(f"{surface}, {titles[sampling]}", fontsize=7)
        line[0].set_ylabel("mean |error| of H")
    for axes in panels[-1]:
        axes.set_xlabel("neighbors K")
    legend_below(figure, panels[0][0])
    save(figure, folder, "supplement-errors")


def main():
    source, folder = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
    errors = results.average(results.read(source / "errors.csv"))
    times = results.read(source / "times.csv")
    results.write(errors, folder / "errors.csv.gz")
    shutil.copyfile(source / "times.csv", folder / "times.csv")
    for surface in results.SURFACES:
        errors_over_k(errors, surface, folder)
        errors_over_noise(errors, surface, folder)
        errors_over_points(errors, surface, folder)
    errors_over_triangles(errors, folder)
    rotations(errors, folder)
    non_uniform(errors, folder)
    times_over_k(times, folder)


if __name__ == "__main__":
    main()
