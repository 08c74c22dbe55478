"""The programs' CSV files as rows, and the errors averaged over the realizations of noise and sampling."""
import csv
import gzip
import io
import math

MEASURES = ("H_mae", "H_rmse", "H_q25", "H_med", "H_q75", "G_mae", "G_rmse", "G_q25", "G_med", "G_q75", "k1_rmse",
            "k2_rmse", "dir_med_deg")
KEY = ("surface", "sampling", "N", "position_noise", "normal_noise", "K", "method")
# Even samples of one size come in exactly that size; others are told apart by their sampling alone.
SURFACES = ("goursat", "torus")

# One look for each method, in every figure: color, line, marker, and the name in legends.
STYLES = {
    "avg-hexagram R=1": ("#0072b2", "-", "o", "avg-hexagram"),
    "avg-hexagram R=2": ("#0072b2", "--", "", "avg-hexagram, R = 2"),
    "avg-hexagram R=3": ("#0072b2", "-.", "", "avg-hexagram, R = 3"),
    "avg-hexagram R=4": ("#0072b2", ":", "", "avg-hexagram, R = 4"),
    "hexagram": ("#e69f00", "-", "h", "hexagram"),
    "uniform L=10": ("#7fd4b8", "-", "", "uniform, L = 10"),
    "uniform L=50": ("#3fb592", "-", "", "uniform, L = 50"),
    "uniform L=100": ("#009e73", "-", "^", "uniform, L = 100"),
    "uniform L=200": ("#00553e", "-", "", "uniform, L = 200"),
    "independent L=100": ("#56b4e9", "-", "v", "independent"),
    "delaunay even": ("#cc79a7", "-", "D", "Delaunay"),
    "delaunay": ("#cc79a7", "--", "", "Delaunay, weighted"),
    "jet degree 2": ("#d55e00", "--", "s", "jet, degree 2"),
    "jet degree 4": ("#d55e00", "-", "s", "jet, degree 4"),
    "aso": ("#000000", "-", "x", "ASO"),
    "normal-regression": ("#882255", "-", "*", "normal-regression"),
    "auto": ("#e6002e", "-", "o", "auto, per point"),
    "auto per cloud": ("#e6002e", ":", "", "auto, per cloud"),
}


def number(text):
    try:
        value = float(text)
    except ValueError:
        return text
    return int(value) if value.is_integer() and "e" not in text and "." not in text else value


def read(path):
    """The rows of a CSV file, cells that are numbers as such."""
    with open(path, newline="") as file:
        return [{name: number(cell) for name, cell in row.items()} for row in csv.DictReader(file)]


def mean(values):
    return sum(values) / len(values)


def average(rows):
    """One row for each cloud, K and method: means over the realizations, and the least and greatest mean error."""
    groups = {}
    for row in rows:
        groups.setdefault(tuple(row["points" if name == "N" else name] for name in KEY), []).append(row)
    averaged = []
    for key, group in groups.items():
        row = dict(zip(KEY, key), realizations=len(group))
        row.update((name, mean([other[name] for other in group])) for name in MEASURES)
        for quantity in "HG":
            errors = [other[f"{quantity}_mae"] for other in group]
            row[f"{quantity}_mae_low"], row[f"{quantity}_mae_high"] = min(errors), max(errors)
        row["failed"] = mean([other["n_fail"] / (other["n_ok"] + other["n_fail"]) for other in group])
        averaged.append(row)
    return averaged


def write(rows, path):
    """Rows of one form as a compressed CSV file, numbers with four digits. The same rows give the same bytes."""
    with gzip.GzipFile(path, "wb", mtime=0) as file, io.TextIOWrapper(file, newline="") as text:
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(rows[0])
        for row in rows:
            writer.writerow([f"{cell:.4g}" if isinstance(cell, float) else cell for cell in row.values()])


def select(rows, **wanted):
    """The rows whose cells are as wanted, in order."""
    return [row for row in rows if all(row[name] == value for name, value in wanted.items())]


def methods_of(rows):
    """The methods that occur, in the legends' order."""
    present = {row["method"] for row in rows}
    return [method for method in STYLES if method in present]


def geometric_mean(values):
    return math.exp(mean([math.log(value) for value in values]))
