#!/usr/bin/python3
"""Which commit programs say that they were built of: version_test.py SOURCE_DIR CURVD CURV"""

import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

SOURCE_DIR, CURVD, CURV = sys.argv[1:]


class VersionTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self._sources = pathlib.Path(folder.name) / "sources"
        self._sources.mkdir()
        self._header = pathlib.Path(folder.name) / "commit.h"

    def _written(self, **environment):
        """The commit in the header that a build of these sources gets."""
        subprocess.run(["cmake", f"-DSOURCE_DIR={self._sources}", f"-DHEADER={self._header}",
                        "-P", f"{SOURCE_DIR}/about/write_commit.cmake"], check=True, env={**os.environ, **environment})
        return self._header.read_text(encoding="utf-8").split('"')[1]

    def _git(self, *words):
        identity = ["-c", "user.name=a", "-c", "user.email=a@b"]
        return subprocess.run(["git", "-C", self._sources, *identity, *words], check=True, capture_output=True,
                              text=True).stdout.strip()

    def test_both_programs_tell_version_and_commit(self):
        curvd, curv = (subprocess.run([program, "--version"], check=True, capture_output=True, text=True).stdout
                       for program in (CURVD, CURV))
        self.assertRegex(curv, r"^curv \d+\.\d+\.\d+ \((commit [\w.-]+|not built in a git clone)\)\n$")
        self.assertEqual(curvd, curv.replace("curv ", "curvd ", 1))

    def test_a_clone_has_its_commit_and_says_whether_files_differ(self):
        self._git("init", "--quiet")
        (self._sources / "file").write_text("1", encoding="utf-8")
        self._git("add", "file")
        self._git("commit", "--quiet", "--message=One")
        commit = self._git("rev-parse", "--short=12", "HEAD")
        self.assertEqual(self._written(), f"commit {commit}")
        (self._sources / "file").write_text("2", encoding="utf-8")
        self.assertEqual(self._written(), f"commit {commit}-dirty")
        self._git("commit", "--quiet", "--all", "--message=Two")
        self._git("tag", "--annotate", "v1.2.3", "--message=1.2.3")
        self.assertEqual(self._written(), "commit v1.2.3")

    def test_a_tarball_says_so_even_within_a_clone_of_something_else(self):
        self._git("init", "--quiet")
        self._sources /= "tarball"
        self._sources.mkdir()
        self.assertEqual(self._written(), "not built in a git clone")

    def test_who_packs_a_tarball_can_tell_the_commit(self):
        self.assertEqual(self._written(CURVD_COMMIT="abc123"), "commit abc123")
        with self.assertRaises(subprocess.CalledProcessError):
            self._written(CURVD_COMMIT='a" b')

    def test_the_same_commit_leaves_the_header_alone(self):
        self._written(CURVD_COMMIT="abc123")
        os.utime(self._header, (1, 1))
        self._written(CURVD_COMMIT="abc123")
        self.assertEqual(self._header.stat().st_mtime, 1)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
