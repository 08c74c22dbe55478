#!/usr/bin/python3
"""Prints a color range for a quantity, symmetric about zero, that holds 96 % of its values:
color_range.py RESULT_CSV mean|gaussian|k1|k2"""
import csv
import math
import sys

COLUMNS = {"mean": "mean_curvature", "gaussian": "gaussian_curvature", "k1": "k1", "k2": "k2"}


def main():
    with open(sys.argv[1], newline="") as file:
        values = [abs(float(row[COLUMNS[sys.argv[2]]] or "nan")) for row in csv.DictReader(file)]
    values = sorted(value for value in values if math.isfinite(value))
    bound = f"{values[int(0.96 * (len(values) - 1))]:.2g}"
    print(f"-{bound}:{bound}")


if __name__ == "__main__":
    main()
