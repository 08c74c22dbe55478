"""Which metrics and labels a PromQL expression asks for. Knows as much of the language as our own queries use."""

import re

# Labels that Prometheus adds to every series, and the metric that it makes itself.
ADDED_LABELS = {"instance", "job"}
ADDED_METRICS = {"up": {}}
WORDS = {"sum", "count", "max", "min", "and", "by", "on", "rate", "increase", "changes", "time", "histogram_quantile", "e"}


def problems(expression, exported):
    """What of the expression does not exist in `exported`, a dict as WatchedCurvd.exported returns."""
    known = {**exported, **ADDED_METRICS}
    found = []
    metrics = set()
    for name, matchers in re.findall(r'\b([a-z][a-z_]*)\b(?=[^"}]*(?:[{"]|$))(?:\{([^}]*)\})?', strip_labels(expression)):
        if name in WORDS:
            continue
        if name not in known:
            found.append(f"{name} is not exported")
            continue
        metrics.add(name)
        for label, operator, text in re.findall(r'([a-z_]+)(=~|!=|=)"([^"]*)"', matchers):
            if label in ADDED_LABELS:
                continue
            if label not in known[name]:
                found.append(f"{name} has no label {label}")
                continue
            for value in text.split("|") if operator == "=~" else [text]:
                if value not in known[name][label]:
                    found.append(f"{name} has no {label}={value}")
    for group in re.findall(r"\b(?:by|on) \(([^)]*)\)", expression):
        for label in group.split(", "):
            if label not in ADDED_LABELS and not any(label in known[name] for name in metrics):
                found.append(f"none of {sorted(metrics)} has a label {label}")
    if not metrics:
        found.append("names no metric")
    return [f"{expression.strip()}: {problem}" for problem in found]


def strip_labels(expression):
    """The expression without the lists of labels behind by and on, and without durations."""
    return re.sub(r"\[[^\]]*\]", "", re.sub(r"\b(by|on) \([^)]*\)", "", expression))
