#!/usr/bin/python3
"""Holds docs/operations.md to what the programs know: operations_test.py CURVD CURV REPOSITORY"""

import pathlib
import re
import subprocess
import sys
import unittest

from watched_curvd import WatchedCurvd

CURVD, CURV, REPOSITORY = sys.argv[1], sys.argv[2], pathlib.Path(sys.argv[3])
DOCUMENT = (REPOSITORY / "docs" / "operations.md").read_text(encoding="utf-8")
ALERTS = (REPOSITORY / "deploy" / "prometheus" / "alerts.yml").read_text(encoding="utf-8")
ALERT_TESTS = (REPOSITORY / "tests" / "deploy" / "alerts_test.yml").read_text(encoding="utf-8")
# Flags of other programs that the page names.
OTHER_FLAGS = {"--build"}


def defined_alerts():
    return re.findall(r"^ +- alert: (\w+)$", ALERTS, re.MULTILINE)


def help_of(*command):
    return subprocess.run([*command, "--help"], check=True, capture_output=True, text=True).stdout


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
        subcommands = re.findall(r"^  ([a-z]+) ", help_of(CURV).partition("Subcommands:")[2], re.MULTILINE)
        self.assertIn("estimate", subcommands)
        texts = [help_of(CURVD), *(help_of(CURV, subcommand) for subcommand in subcommands)]
        known = set(re.findall(r"--[a-z-]+", "".join(texts)))
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
