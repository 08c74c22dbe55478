#!/usr/bin/python3
"""Draws cost a point against points and against K: plot.py RESULTS IMAGES"""
import csv
import math
import pathlib
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt


def read_columns(path, *names):
    with open(path, newline="") as file:
        rows = list(csv.DictReader(file))
    return [[float(row[name]) for row in rows] for name in names]


def draw(x, y, bound, bound_name, x_name, y_scale, path):
    """The measured curve, and the one through its first point that it should stay below."""
    figure, axes = plt.subplots(figsize=(6.4, 4.0), dpi=120)
    axes.plot(x, y, marker="o", color="#1f5fa8", label="curvd, one thread")
    axes.plot(x, bound, linestyle="--", color="#a0a0a0", label=bound_name)
    axes.set_xscale("log")
    axes.set_yscale(y_scale)
    if y_scale == "linear":
        axes.set_ylim(bottom=0.0)
    axes.set_xlabel(x_name)
    axes.set_ylabel("CPU microseconds a point")
    axes.grid(True, which="both", linewidth=0.3)
    axes.legend(frameon=False)
    figure.tight_layout()
    # Without a date, the same figures give the same file.
    figure.savefig(path, metadata={"Software": None})


def main():
    results, images = map(pathlib.Path, sys.argv[1:3])
    points, cost = read_columns(results / "scaling_points.csv", "points", "us/point")
    bound = [cost[0] * math.log(n) / math.log(points[0]) for n in points]
    draw(points, cost, bound, "growth of N log N", "points N (K = 50)", "linear", images / "cost_by_points.png")
    neighbors, cost = read_columns(results / "scaling_neighbors.csv", "K", "us/point")
    bound = [cost[0] * k / neighbors[0] for k in neighbors]
    draw(neighbors, cost, bound, "linear growth", "neighbors K", "log", images / "cost_by_neighbors.png")


if __name__ == "__main__":
    main()
