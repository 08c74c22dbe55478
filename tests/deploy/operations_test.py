#!/usr/bin/python3
"""Holds docs/operations.md to what the programs know: operations_test.py CURVD REPOSITORY"""

import pathlib
import re
import subprocess
import sys
import unittest

from watched_curvd import WatchedCurvd

CURVD, REPOSITORY = sys.argv[1], pathlib.Path(sys.argv[2])
DOCUMENT = (REPOSITORY / "docs" / "operations.md").read_text(encoding="utf-8")
ALERTS = (REPOSITORY / "deploy" / "prometheus" / "alerts.yml").read_text(encoding="utf-8")
ALERT_TESTS = (REPOSITORY / "tests" / "deploy" / "alerts_test.yml").read_text(encoding="utf-8")
# Flags of other programs that the page names.
OTHER_FLAGS = {"--build", "--server"}


def defined_alerts():
    return re.findall(r"^ +- alert: (\w+)$", ALERTS, re.MULTILINE)


class OperationsTest(unittest.TestCase):
    def test_every_alert_has_its_section_and_every_section_its_alert(self):
        sections = re.findall(r"^### (Curvd\w+)$", DOCUMENT, re.MULTILINE)
        self.assertEqual(sorted(sections), sorted(defined_alerts()))
        runbooks = re.findall(r"runbook: docs/operations\.md#(\w+)$", ALERTS, re.MULTILINE)
        self.assertEqual(runbooks, [name.lower() for name in defined_alerts()])

    def test_every_alert_is_seen_to_fire(self):
        fired = re.findall(r"alertname: (\w+)\n +exp_alerts:\n", ALERT_TESTS)
        self.assertEqual(sorted(set(fired)), sorted(defined_alerts()))

    def test_every_flag_exists(self):
        known = set(re.findall(r"--[a-z-]+", subprocess.run([CURVD, "--help"], check=True, capture_output=True,
                                                            text=True).stdout))
        named = set(re.findall(r"(?<![\w-])--[a-z][a-z-]+", DOCUMENT))
        self.assertGreater(len(named), 9)
        self.assertEqual(named - known - OTHER_FLAGS, set())

    def test_every_metric_exists(self):
        with WatchedCurvd(CURVD) as server:
            # The parts of a histogram go by its name.
            known = {re.sub("_(bucket|sum|count)$", "", name) for name in server.exported()}
        # What prometheus-cpp's port tells of its own scrapes.
        known = {name for name in known if not name.startswith("exposer_")}
        named = set(re.findall(r"`((?:curvd|process|grpc_server)_[a-z_]+)(?:\{[^`]*)?`", DOCUMENT))
        self.assertEqual(named - known, set())
        # And the other way round: what is exported has a question that it answers.
        self.assertEqual(known - named, set())

    def test_every_link_leads_somewhere(self):
        anchors = {re.sub(r"[^\w -]", "", title).lower().replace(" ", "-")
                   for title in re.findall(r"^#+ (.*)$", DOCUMENT, re.MULTILINE)}
        for target in re.findall(r"\]\(([^)]+)\)", DOCUMENT):
            if target.startswith("http"):
                continue
            with self.subTest(target):
                path, _, anchor = target.partition("#")
                if path:
                    self.assertTrue((REPOSITORY / "docs" / path).exists())
                else:
                    self.assertIn(anchor, anchors)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
