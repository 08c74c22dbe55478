#!/usr/bin/python3
"""What curvd_client.dask says where something is missing or wrong: dask_test.py CURV. PYTHONPATH names the package."""

import pathlib
import stat
import subprocess
import sys
import tempfile
import unittest
from unittest import mock

from curvd_client.dask import TilesError, run_tiles

CURV = sys.argv[1]


def has_distributed():
    try:
        import distributed
    except ImportError:
        return False
    return bool(distributed)


class WithoutDistributed(unittest.TestCase):
    def test_says_what_to_install(self):
        with mock.patch.dict(sys.modules, {"distributed": None}):
            with self.assertRaisesRegex(ImportError, "python3-distributed"):
                run_tiles("anywhere")


@unittest.skipUnless(has_distributed(), "distributed is not installed")
class RunTiles(unittest.TestCase):
    def setUp(self):
        holder = tempfile.TemporaryDirectory()
        self.addCleanup(holder.cleanup)
        self.folder = pathlib.Path(holder.name)
        self.work = self.folder / "work"

    def plan(self):
        cloud = self.folder / "cloud.xyz"
        lines = [f"{i % 40} {i // 40} {(i * 7919 % 13) * 0.01} 0 0 1" for i in range(1600)]
        cloud.write_text("# x y z nx ny nz\n" + "\n".join(lines), encoding="ascii")
        subprocess.run([CURV, "tiles", "plan", cloud, "-o", self.work, "--tile-points=500"], check=True, capture_output=True)

    def program(self, text):
        """Stands for curv; {curv} in the text is curv."""
        path = self.folder / "program"
        path.write_text("#!/bin/sh\n" + text.format(curv=CURV, folder=self.folder), encoding="ascii")
        path.chmod(path.stat().st_mode | stat.S_IXUSR)
        return str(path)

    def test_does_what_is_left_on_threads_of_this_process(self):
        self.plan()
        subprocess.run([CURV, "tiles", "run", self.work, "--tile=0", "--threads=1"], check=True, capture_output=True)
        done = run_tiles(self.work, curv=CURV)
        self.assertEqual((done.tiles, done.tasks), (3, 3))
        self.assertGreater(done.points, 1000)
        self.assertEqual(run_tiles(self.work, curv=CURV), (0, 0, 0))

    def test_tries_again_what_ended_by_chance(self):
        self.plan()
        once = self.program('case "$*" in *--tile=2*) [ -e {folder}/tried ] || {{ touch {folder}/tried; kill -9 $$; }};; esac\n'
                            'exec {curv} "$@"\n')
        done = run_tiles(self.work, curv=once)
        self.assertEqual((done.tiles, done.tasks), (4, 5))

    def test_gives_up_at_once_what_is_hopeless_and_later_what_is_not(self):
        self.plan()
        for code, tasks in ((4, 1), (5, 3)):
            with self.subTest(code):
                (self.folder / "count").write_text("", encoding="ascii")
                bad = self.program('case "$*" in *--tile=1*) echo >>{folder}/count; echo disk is full >&2; exit ' + str(code) +
                                   ';; esac\nexec {curv} "$@"\n')
                with self.assertRaisesRegex(TilesError, "tile 1: disk is full") as raised:
                    run_tiles(self.work, curv=bad, max_attempts=3)
                self.assertEqual((raised.exception.tile, raised.exception.exit_code), (1, code))
                self.assertEqual(len((self.folder / "count").read_text(encoding="ascii")), tasks)

    def test_names_what_is_wrong_with_arguments(self):
        with self.assertRaisesRegex(TilesError, "no-such-program"):
            run_tiles(self.work, curv="no-such-program")
        with self.assertRaisesRegex(TilesError, "work") as raised:
            run_tiles(self.work, curv=CURV)
        self.assertEqual(raised.exception.exit_code, 3)
        with self.assertRaisesRegex(ValueError, "max_attempts is 0"):
            run_tiles(self.work, curv=CURV, max_attempts=0)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
