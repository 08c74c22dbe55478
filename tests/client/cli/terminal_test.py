#!/usr/bin/python3
"""What curv writes for people: the same digits in every locale, and nothing but text: terminal_test.py CURV"""

import os
import pathlib
import pty
import re
import subprocess
import sys
import tempfile
import unittest

CURV = sys.argv.pop(1)


def curv(folder, *words, **environment):
    run = subprocess.run([CURV, *words], cwd=folder, capture_output=True, check=False, env={**os.environ, **environment})
    assert run.returncode == 0, run.stderr
    return run.stdout + run.stderr


def on_terminal(folder, *words, **environment):
    """What the command wrote on a terminal."""
    mine, theirs = pty.openpty()
    process = subprocess.Popen([CURV, *words], cwd=folder, stdout=theirs, stderr=theirs, env={**os.environ, **environment})
    os.close(theirs)
    written = b""
    try:
        while block := os.read(mine, 4096):
            written += block
    except OSError:  # the end of a terminal
        pass
    os.close(mine)
    assert process.wait() == 0, written
    return written


class Locales(unittest.TestCase):
    def setUp(self):
        name = tempfile.TemporaryDirectory()
        self.addCleanup(name.cleanup)
        self.folder = pathlib.Path(name.name)
        # Debian's machines have none but C unless asked.
        subprocess.run(["localedef", "-i", "de_DE", "-f", "UTF-8", self.folder / "de_DE.UTF-8"], check=True, capture_output=True)
        self.german = {"LC_ALL": "de_DE.UTF-8", "LOCPATH": str(self.folder)}
        told = subprocess.run(["locale", "decimal_point"], capture_output=True, text=True, check=True,
                              env={**os.environ, **self.german})
        self.assertEqual(told.stdout.strip(), ",", "the locale is not in force")

    def test_files_and_reports_are_the_same_under_a_decimal_comma(self):
        commands = [
            ["generate", "goursat", "--points=500", "--noise-position=0.05", "-o", "cloud.ply"],
            ["estimate", "cloud.ply", "-o", "out.csv", "--radius=7.5"],
            ["estimate", "out.csv", "-o", "out.xyz"],
            ["estimate", "out.csv", "-o", "out.ply", "--ascii"],
            ["estimate", "out.csv", "-o", "out.pcd", "--ascii"],
            ["estimate", "out.csv", "-o", "out.las"],
            ["select", "out.csv", "--where", "mean_curvature < 0.125", "-o", "part.csv"],
            ["evaluate", "out.csv"],
        ]
        seen = {}
        for name, environment in [("C", {"LC_ALL": "C"}), ("german", self.german)]:
            folder = self.folder / name
            folder.mkdir()
            texts = [re.sub(rb"\d+\.\d{3}(?= |,|\n)", b"TIME", curv(folder, *words, **environment)) for words in commands]
            files = {path.name: path.read_bytes() for path in sorted(folder.iterdir())}
            seen[name] = (texts, files)
        self.assertEqual(len(seen["C"][1]), 7)
        self.assertEqual(seen["C"], seen["german"])
        self.assertGreater(len(seen["C"][1]["part.csv"].splitlines()), 10)


class Terminals(unittest.TestCase):
    def setUp(self):
        name = tempfile.TemporaryDirectory()
        self.addCleanup(name.cleanup)
        self.folder = pathlib.Path(name.name)
        curv(self.folder, "generate", "torus", "--points=100000", "-o", "cloud.ply")

    def test_nothing_is_colored_and_a_dumb_terminal_gets_text_alone(self):
        estimate = ["estimate", "cloud.ply", "-o", "out.ply", "--k=200"]
        redrawn = on_terminal(self.folder, *estimate, TERM="xterm-256color")
        self.assertIn(b"\r\x1b[K", redrawn)  # the progress bar, which clears its line
        self.assertEqual(set(re.findall(rb"\x1b[^a-zA-Z]*[a-zA-Z]", redrawn)), {b"\x1b[K"})
        self.assertNotIn(b"\x1b", on_terminal(self.folder, *estimate, TERM="dumb"))
        self.assertNotIn(b"\x1b", curv(self.folder, *estimate, TERM="xterm-256color"))
        for words in (["--help"], ["estimate", "--help"], ["doctor", "--help"]):
            self.assertNotIn(b"\x1b", on_terminal(self.folder, *words, TERM="xterm-256color"))

    def test_one_bar_shows_all_of_several_files_and_never_goes_back(self):
        (self.folder / "other.ply").write_bytes((self.folder / "cloud.ply").read_bytes())
        written = on_terminal(self.folder, "estimate", "cloud.ply", "other.ply", "-o", "out/", "--k=200", TERM="xterm-256color")
        shown = re.findall(rb"\[[#.]{20}\] +(\d+) %, (\d) of 2, (\w+)\.ply: ", written)
        self.assertEqual({(which, name) for _, which, name in shown}, {(b"1", b"cloud"), (b"2", b"other")}, written)
        shares = [int(share) for share, _, _ in shown]
        self.assertEqual(shares, sorted(shares))
        self.assertLessEqual(max(share for share, (_, which, _) in zip(shares, shown) if which == b"1"), 50)
        self.assertGreaterEqual(min(share for share, (_, which, _) in zip(shares, shown) if which == b"2"), 50)
        self.assertIn(b"2 files: 2 done, 0 skipped, 0 failed", written)


if __name__ == "__main__":
    unittest.main()
