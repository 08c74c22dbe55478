#!/usr/bin/python3
"""Draws what the automatic choice reaches, and writes its tables: automatic.py RESULTS FOLDER

RESULTS holds automatic.csv of automatic_curves; the figures go to FOLDER as SVG, and the rows as automatic.csv. RESULTS
gets automatic_ratios.csv and automatic_coverage.csv, tables of docs/paper/README.md."""
import csv
import pathlib
import shutil
import sys

import curves
import matplotlib.pyplot as plt
import results

AUTO = ("auto", "auto per cloud")
WANTED = (80, 97)  # percent of the intervals, where there is noise


def levels(rows):
    return sorted({(row["position_noise"], row["normal_noise"]) for row in rows})


def level_name(level):
    return f"{level[0]:g} / {level[1]:g}"


def at_levels(rows, column, **wanted):
    """The column's value at each noise level, in order; NaN where a hundredth of the points has none."""
    chosen = {(row["position_noise"], row["normal_noise"]): row for row in results.select(rows, **wanted)}
    return [chosen[level][column] if level in chosen and chosen[level]["failed"] < 0.01 else float("nan")
            for level in levels(rows)]


def noise_axis(axes, rows):
    axes.set_xticks(range(len(levels(rows))), [level_name(level) for level in levels(rows)], rotation=45, ha="right")
    axes.set_xlabel("noise of positions / normals")
    axes.grid(True, axis="y", linewidth=0.4, color="#d0d0d0")
    axes.set_axisbelow(True)


def errors_over_noise(rows, folder):
    """A thin line for each estimator at each neighbor count, and auto in front of them."""
    figure, panels = plt.subplots(1, 2, figsize=(curves.PAGE, 3.7))
    for axes, surface in zip(panels, results.SURFACES):
        of_surface = results.select(rows, surface=surface)
        for method in results.methods_of(of_surface):
            color, style, _, name = results.STYLES[method]
            if method in AUTO:
                axes.plot(at_levels(of_surface, "H_mae", method=method), color=color, linestyle=style, linewidth=2,
                          label=name, zorder=5)
                continue
            for i, k in enumerate(sorted({row["K"] for row in results.select(of_surface, method=method)})):
                axes.plot(at_levels(of_surface, "H_mae", method=method, K=k), color=color, linewidth=0.6, alpha=0.45,
                          label=name if i == 0 else None)
        axes.set_yscale("log")
        axes.set_title(surface)
        noise_axis(axes, of_surface)
    panels[0].set_ylabel("mean |error| of H")
    curves.legend_below(figure, panels[0], columns=4)
    curves.save(figure, folder, "automatic-errors")


def coverage_over_noise(rows, folder):
    """How many of the intervals hold the truth."""
    figure, panels = plt.subplots(1, 2, figsize=(curves.PAGE, 2.9), sharey=True)
    for axes, surface in zip(panels, results.SURFACES):
        of_surface = results.select(rows, surface=surface)
        axes.axhspan(*WANTED, color="#dddddd", linewidth=0)
        axes.axhline(90, color="black", linewidth=0.6)
        for quantity, color, marker in (("H", "#0072b2", "o"), ("k1", "#009e73", "^"), ("k2", "#d55e00", "s")):
            axes.plot(at_levels(of_surface, f"{quantity}_held", method="auto"), color=color, marker=marker,
                      linewidth=0.8, label=quantity)
        axes.set_title(surface)
        axes.set_ylim(50, 101)
        noise_axis(axes, of_surface)
    panels[0].set_ylabel("intervals with the truth, %")
    curves.legend_below(figure, panels[0])
    curves.save(figure, folder, "automatic-coverage")


def best_fixed(rows, quantity):
    """The fixed estimate with the least mean error; of the paper's estimators and its peers."""
    return min((row for row in rows if row["K"] > 0 and row["failed"] < 0.01 and row["method"] != "normal-regression"),
               key=lambda row: row[f"{quantity}_mae"])


def write_tables(rows, folder):
    ratios, coverage = [], []
    for surface in results.SURFACES:
        of_surface = results.select(rows, surface=surface)
        for level in levels(of_surface):
            case = results.select(of_surface, position_noise=level[0], normal_noise=level[1])
            best, best_g = best_fixed(case, "H"), best_fixed(case, "G")
            point, cloud = (results.select(case, method=method)[0] for method in AUTO)
            ratios.append([surface, level_name(level), f"{results.STYLES[best['method']][3]}, {best['K']}",
                           *[f"{row['H_mae'] / best['H_mae']:.2f}" for row in (point, cloud)],
                           f"{point['G_mae'] / best_g['G_mae']:.2f}", point["median_K"]])
            coverage.append([surface, level_name(level), *[f"{point[f'{q}_held']:.0f}" for q in ("H", "k1", "k2")]])
    mean = lambda column: f"{results.geometric_mean([float(row[column]) for row in ratios]):.2f}"
    ratios.append(["geometric mean", "", "", mean(3), mean(4), mean(5), ""])
    for name, header, table in (
            ("automatic_ratios", ["surface", "noise", "best fixed estimate", "per point", "per cloud", "G", "median K"],
             ratios),
            ("automatic_coverage", ["surface", "noise", "H", "k1", "k2"], coverage)):
        with open(folder / f"{name}.csv", "w", newline="") as file:
            csv.writer(file).writerows([header, *table])


def main():
    source, folder = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
    rows = results.read(source / "automatic.csv")
    shutil.copyfile(source / "automatic.csv", folder / "automatic.csv")
    errors_over_noise(rows, folder)
    coverage_over_noise(rows, folder)
    write_tables(rows, source)


if __name__ == "__main__":
    main()
