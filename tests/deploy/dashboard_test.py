#!/usr/bin/python3
"""Runs the dashboard's queries and the alert rules against a Prometheus that scrapes a curvd at work:
dashboard_test.py CURVD CURV DEPLOY_DIR

Every metric, label and label value that a query or rule names must be exported; every query must parse and give
numbers; every rule must evaluate, and none may fire.
"""

import json
import math
import pathlib
import re
import socket
import subprocess
import sys
import tempfile
import time
import unittest
import urllib.parse
import urllib.request

import promql
from watched_curvd import WatchedCurvd

CURVD, CURV, DEPLOY_DIR = sys.argv[1], sys.argv[2], pathlib.Path(sys.argv[3])
PATIENCE_SECONDS = 120


def dashboard_queries():
    """(panel, expression) of each query, with Grafana's variables resolved."""
    dashboard = json.loads((DEPLOY_DIR / "grafana" / "curvd.json").read_text(encoding="utf-8"))
    for panel in dashboard["panels"]:
        for target in panel.get("targets", []):
            yield panel["title"], target["expr"].replace("$__rate_interval", "1m").replace("$instance", ".*")


def alert_expressions():
    text = (DEPLOY_DIR / "prometheus" / "alerts.yml").read_text(encoding="utf-8")
    for folded, plain in re.findall(r"^ +expr: (?:>\n((?: {10,}.*\n)+)|(.*))", text, re.MULTILINE):
        yield " ".join((folded or plain).split())


class Prometheus:
    """Scrapes one target and evaluates the alert rules, both once a second."""

    def __init__(self, folder, target):
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            self._address = "127.0.0.1:%d" % free.getsockname()[1]
        config = pathlib.Path(folder) / "prometheus.yml"
        config.write_text(json.dumps({
            "global": {"scrape_interval": "1s", "scrape_timeout": "1s", "evaluation_interval": "1s"},
            "rule_files": [str((DEPLOY_DIR / "prometheus" / "alerts.yml").resolve())],
            "scrape_configs": [{"job_name": "curvd", "static_configs": [{"targets": [target]}]}],
        }), encoding="utf-8")
        self._process = subprocess.Popen(
            ["prometheus", f"--config.file={config}", f"--storage.tsdb.path={folder}/tsdb",
             f"--web.listen-address={self._address}", "--log.level=error"])

    def stop(self):
        self._process.terminate()
        self._process.wait()

    def ask(self, path, **parameters):
        url = f"http://{self._address}/api/v1/{path}?{urllib.parse.urlencode(parameters)}"
        try:
            with urllib.request.urlopen(url, timeout=30) as answer:
                return json.load(answer)["data"]
        except urllib.error.HTTPError as error:
            if error.code == 400:
                raise ValueError(f"{parameters}: {error.read().decode()}") from error
            raise

    def has_numbers(self, expression):
        result = self.ask("query", query=expression)["result"]
        return any(math.isfinite(float(series["value"][1])) for series in result)


class DashboardTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls._folder = cls.enterClassContext(tempfile.TemporaryDirectory())
        cls.curvd = cls.enterClassContext(WatchedCurvd(CURVD))
        cls.prometheus = Prometheus(cls._folder, cls.curvd.metrics_address)
        cls.addClassCleanup(cls.prometheus.stop)
        cls._cloud = f"{cls._folder}/torus.ply"
        subprocess.run([CURV, "generate", "torus", "--points=5000", "-o", cls._cloud], check=True,
                       stdout=subprocess.DEVNULL)

    def estimate(self, neighbors):
        return subprocess.run([CURV, "estimate", self._cloud, "-o", f"{self._folder}/out.ply", f"--k={neighbors}",
                               f"--server={self.curvd.address}"], check=False, capture_output=True).returncode

    def work(self):
        self.assertEqual(self.estimate(20), 0)
        self.assertNotEqual(self.estimate(100_000), 0)  # NEIGHBORHOOD_TOO_LARGE

    def test_names_what_is_exported(self):
        self.work()
        exported = self.curvd.exported()
        expressions = [expression for _, expression in dashboard_queries()] + list(alert_expressions())
        self.assertGreater(len(expressions), 40)
        for expression in expressions:
            with self.subTest(expression):
                self.assertEqual(promql.problems(expression, exported), [])

    def test_the_check_itself_finds_what_is_wrong(self):
        exported = self.curvd.exported()
        for wrong in ("curvd_pints_total", 'curvd_points_total{state="ok"}', 'curvd_points_total{status=~"ok|fine"}',
                      "sum by (le, phase) (curvd_points_total)", "rate(crvd_points_total[5m])", "time() - 5"):
            with self.subTest(wrong):
                self.assertNotEqual(promql.problems(wrong, exported), [])

    def test_every_panel_shows_numbers(self):
        left = list(dashboard_queries())
        deadline = time.monotonic() + PATIENCE_SECONDS
        while left:
            self.assertLess(time.monotonic(), deadline, f"no numbers for {left}")
            self.work()  # rates need something that moves
            try:
                left = [(panel, query) for panel, query in left if not self.prometheus.has_numbers(query)]
            except urllib.error.URLError:
                pass  # Prometheus is still starting

    def test_every_rule_evaluates_and_none_fires(self):
        deadline = time.monotonic() + PATIENCE_SECONDS
        rules = []
        while not rules or any(rule["health"] == "unknown" for rule in rules):
            self.assertLess(time.monotonic(), deadline, "Prometheus did not evaluate the rules")
            try:
                rules = [rule for group in self.prometheus.ask("rules")["groups"] for rule in group["rules"]]
            except urllib.error.URLError:
                pass  # still starting
        self.assertEqual(len(rules), len(list(alert_expressions())))
        for rule in rules:
            with self.subTest(rule["name"]):
                self.assertEqual(rule["health"], "ok", rule.get("lastError"))
                self.assertNotEqual(rule["state"], "firing")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
