#!/usr/bin/python3
"""`make build-deps` beside another apt, which is played here: packages_test.py SOURCE_DIR"""

import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

SOURCE_DIR = sys.argv.pop(1)
# `apt-get update` says what it does without a network, or while another holds its lock, as often as the file "locked" has lines.
APT = """#!/bin/bash
echo "$*" >>"$PLAYED/calls"
case "$*" in
  update*) [ ! -e "$PLAYED/offline" ] || { echo "E: Failed to fetch http://deb.example" >&2; exit 100; }
    [ ! -s "$PLAYED/locked" ] || { sed -i 1d "$PLAYED/locked"; echo "E: Could not get lock /var/lib/apt/lists/lock." >&2; exit 100; } ;;
esac
"""


class Packages(unittest.TestCase):
    def make(self, **files):
        with tempfile.TemporaryDirectory() as name:
            played = pathlib.Path(name)
            for program, text in {"apt-get": APT, "dpkg-query": "#!/bin/sh\nexit 1\n", "sudo": '#!/bin/sh\nexec "$@"\n'}.items():
                (played / program).write_text(text, encoding="ascii")
                (played / program).chmod(0o755)
            for file, text in files.items():
                (played / file).write_text(text, encoding="ascii")
            run = subprocess.run(["make", "-C", SOURCE_DIR, "build-deps", "APT_PAUSE=0"], capture_output=True, text=True, check=False,
                                 env={**os.environ, "PATH": f"{played}:{os.environ['PATH']}", "PLAYED": name, "MAKEFLAGS": ""})
            return run, (played / "calls").read_text(encoding="ascii").splitlines()

    def test_another_apt_is_waited_for(self):
        run, calls = self.make(locked="once\ntwice\n")
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertEqual([call.split()[0] for call in calls[:3]], ["update"] * 3)
        self.assertIn("DPkg::Lock::Timeout=600 install", calls[3])
        self.assertIn("libgrpc++-dev", calls[3])
        self.assertIn("Waiting for another apt", run.stdout)

    def test_other_failures_end_it_at_once(self):
        run, calls = self.make(offline="yes")
        self.assertNotEqual(run.returncode, 0)
        self.assertEqual(len(calls), 1)
        self.assertIn("Failed to fetch", run.stderr)


if __name__ == "__main__":
    unittest.main()
