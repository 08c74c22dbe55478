#!/usr/bin/python3
"""Sends files that are larger than a server takes, as `curv estimate` does, in one piece and in tiles.

  estimate_in_tiles_test.py CURV CURVD
"""

import json
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile
import unittest

from tiles_test import CURV, FAILED, INPUT, OK, USAGE, Server, curv

POINTS, LIMIT = 20_000, 8_000
INTERRUPTED = 130


class EstimateInTiles(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="curv-estimate-tiles-"))
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        cls.cloud = str(cls.folder / "cloud.ply")
        curv("generate", "goursat", f"--points={POINTS}", "--noise-position=0.1", "--noise-normal=0.1", "-o", cls.cloud)
        cls.whole = cls.folder / "whole.ply"
        curv("estimate", cls.cloud, "-o", str(cls.whole))
        server = Server(0, f"--max-points={LIMIT}")
        cls.addClassCleanup(server.kill)
        cls.address = f"--server={server.address}"

    def setUp(self):
        self.out = self.folder / "out.ply"
        self.tiles = self.folder / "out.ply.tiles"
        self.addCleanup(self.out.unlink, missing_ok=True)
        self.addCleanup(shutil.rmtree, self.tiles, ignore_errors=True)

    def estimate(self, *flags, code=OK):
        return curv("estimate", self.cloud, "-o", str(self.out), self.address, *flags, code=code)

    def test_a_file_that_is_too_large_names_points_limit_and_the_way_out(self):
        message = self.estimate(code=FAILED)
        for word in (self.cloud, "20,000 points", f"at most {LIMIT}", "--tiles"):
            self.assertIn(word, message)
        self.assertFalse(self.out.exists())

    def test_a_file_that_is_too_large_is_sent_on_no_way_that_is_closed(self):
        for flag in ("--auto", "--normals=estimate", "--color"):
            with self.subTest(flag=flag):
                message = self.estimate(flag, code=FAILED)
                self.assertIn("--tiles would estimate them in parts, but cannot here: --", message)
                self.assertNotIn("same result", message)

    def test_tiles_have_the_bytes_of_the_whole(self):
        summary = json.loads(self.estimate("--tiles", "--summary=json"))
        self.assertEqual(summary["points"], POINTS)
        self.assertGreater(summary["tiles"], POINTS // LIMIT)
        self.assertEqual(self.out.read_bytes(), self.whole.read_bytes())
        self.assertFalse(self.tiles.exists())

    def test_works_without_a_server_and_in_a_given_directory(self):
        elsewhere = self.folder / "elsewhere"
        text = curv("estimate", self.cloud, "-o", str(self.out), "--tiles", f"--tiles-directory={elsewhere}")
        self.assertIn("20,000 points in 1 tile,", text)
        self.assertEqual(self.out.read_bytes(), self.whole.read_bytes())
        self.assertFalse(elsewhere.exists())

    def test_an_interrupted_command_goes_on(self):
        command = [CURV, "estimate", self.cloud, "-o", str(self.out), self.address, "--tiles"]
        results = self.tiles / "results"
        process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        while process.poll() is None and not (results.exists() and os.listdir(results)):
            pass
        process.send_signal(signal.SIGINT)
        _, message = process.communicate(timeout=60)
        self.assertEqual(process.returncode, INTERRUPTED)
        self.assertIn(f"in {self.tiles}: the same command goes on", message)
        self.assertFalse(self.out.exists())
        done = [name for name in os.listdir(results) if name.startswith("tile-")]
        self.assertIn("other options", self.estimate("--tiles", "--k=20", code=USAGE))

        (self.tiles / "of mine").write_text("stays", encoding="utf-8")
        summary = json.loads(self.estimate("--tiles", "--summary=json"))
        self.assertEqual(summary["tiles_done_before"], len(done))
        self.assertEqual(self.out.read_bytes(), self.whole.read_bytes())
        self.assertEqual(os.listdir(self.tiles), ["of mine"])

    def test_other_files_in_the_directory_stay(self):
        self.tiles.mkdir()
        note = self.tiles / "note"
        note.write_text("mine", encoding="ascii")
        self.assertIn("holds other things", self.estimate("--tiles", code=USAGE))
        self.assertEqual(note.read_text(encoding="ascii"), "mine")

    def test_a_file_that_cannot_be_planned_leaves_nothing(self):
        bad = self.folder / "bad.xyz"
        bad.write_text("# x y z nx ny nz\n0 0 0 0 0 1\nnan 0 0 0 0 1\n", encoding="ascii")
        message = curv("estimate", str(bad), "-o", str(self.out), self.address, "--tiles", code=INPUT)
        self.assertIn("point 1 has a position that is not finite", message)
        self.assertFalse(self.tiles.exists())

    def test_refuses_what_no_tile_can_decide(self):
        for flags, word in ((["--auto"], "--auto"), (["--k=auto"], "--k=auto"), (["--normals=estimate"], "curv normals"),
                            (["--orient"], "curv orient"), (["--estimator=delaunay", "--k=20"], "31"),
                            (["--color"], "--color"), (["--also=standard_errors"], "standard_errors"),
                            (["--direction=z"], "--direction"), (["--on-opposed-normals=reject"], "--on-opposed-normals"),
                            ([self.cloud], "one file")):
            with self.subTest(flags=flags):
                self.assertIn(word, self.estimate("--tiles", *flags, code=USAGE))
        self.assertIn("--tiles", self.estimate("--tiles-directory=elsewhere", code=USAGE))
        self.assertFalse(self.tiles.exists())


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
