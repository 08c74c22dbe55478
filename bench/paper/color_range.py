#!/usr/bin/python3
"""Prints a color range for a quantity that holds 96 % of its values, symmetric about zero, but for counts:
color_range.py RESULT_CSV mean|gaussian|k1|k2|chosen_neighbor_count"""
import csv
import math
import sys

COLUMNS = {"mean": "mean_curvature", "gaussian": "gaussian_curvature", "k1": "k1", "k2": "k2"}


def main():
    with open(sys.argv[1], newline="") as file:
        name = COLUMNS.get(sys.argv[2], sys.argv[2])
        values = [abs(float(row[name] or "nan")) for row in csv.DictReader(file)]
    values = sorted(value for value in values if math.isfinite(value))
    if name == "chosen_neighbor_count":
        print(f"{values[int(0.02 * (len(values) - 1))]:.0f}:{values[int(0.98 * (len(values) - 1))] + 0.5:.0f}")
        return
    bound = f"{values[int(0.96 * (len(values) - 1))]:.2g}"
    print(f"-{bound}:{bound}")


if __name__ == "__main__":
    main()
