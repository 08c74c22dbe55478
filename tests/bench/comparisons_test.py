#!/usr/bin/python3
"""bench/compare_builds.py and bench/same_bytes.py on programs that play builds: comparisons_test.py BENCH_DIR"""

import pathlib
import subprocess
import sys
import tempfile
import unittest

BENCH_DIR = pathlib.Path(sys.argv[1])


def run(script, *arguments):
    done = subprocess.run([sys.executable, BENCH_DIR / script, *arguments], capture_output=True, text=True, check=False)
    return done.returncode, done.stdout, done.stderr


def ply(points, comment="of one build"):
    """A command that writes a PLY file with that comment and those points to $out."""
    return f'printf "ply\\ncomment {comment}\\nend_header\\n{points}" >$out'


class ComparisonsTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def program(self, path, script):
        path = self.folder / path
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(f"#!/bin/sh\n{script}\n", encoding="utf-8")
        path.chmod(0o755)

    def build(self, name, table):
        """A build whose core benchmark writes that table."""
        write = f'printf "{table}" >"${{a#--out=}}/t.csv"'
        self.program(f"{name}/bin/core_bench", f"for a; do case $a in --out=*) {write};; esac; done")
        return self.folder / name

    def compare(self, old, new):
        return run("compare_builds.py", self.build("old", old), self.build("new", new), "--turns=2", "--programs=core")

    def test_equal_figures_are_equal(self):
        status, output, errors = self.compare("what,a ms\\nx,2\\n", "what,a ms\\nx,2\\n")
        self.assertEqual(status, 0, errors)
        self.assertIn("1 figures, 0 farther than 0.02 from 1, 0 not told to 0.02; 0 not compared", output)

    def test_a_slower_figure_is_marked(self):
        status, output, _ = self.compare("what,a ms\\nx,2\\n", "what,a ms\\nx,3\\n")
        self.assertEqual(status, 1)
        self.assertIn("t: x: a ms  <-", output)

    def test_turns_that_disagree_tell_nothing(self):
        first_1_then_3 = "$([ -e $0.ran ] && echo 3 || echo 1; : >$0.ran)"
        status, output, errors = self.compare("what,a ms\\nx,2\\n", f"what,a ms\\nx,{first_1_then_3}\\n")
        self.assertEqual(status, 0, errors)
        self.assertIn("t: x: a ms  ?", output)

    def test_columns_have_geometric_means(self):
        _, output, _ = self.compare("what,a ms\\nx,2\\ny,2\\n", "what,a ms\\nx,4\\ny,1\\n")
        self.assertIn(" 1.000   1.000  t: a ms (2 rows)", output)

    def test_figures_of_one_build_are_named(self):
        status, output, _ = self.compare("what,a ms,b ms\\nx,2,1\\n", "what,a ms,c ms\\nx,2,1\\n")
        self.assertEqual(status, 0)
        self.assertIn("not compared, only in OLD_BUILD: t: x: b ms", output)
        self.assertIn("not compared, only in NEW_BUILD: t: x: c ms", output)

    def test_nothing_compared_is_a_failure(self):
        self.assertEqual(self.compare("what,a ms\\nx,2\\n", "what,a ms\\ny,2\\n")[0], 1)
        self.assertEqual(self.compare("what\\nx\\n", "what\\nx\\n")[0], 1)

    def bytes_of(self, *estimates, only="17-points"):
        """Compares builds whose curv estimate runs those commands, with the output's path in $out."""
        for i, estimate in enumerate(estimates):
            self.program(f"{i}/curv", f'[ "$1" = generate ] && exit 0\nout=$4\n{estimate}')
        return run("same_bytes.py", *(self.folder / str(i) for i in range(len(estimates))), f"--only={only}")

    def test_same_bytes_are_the_same(self):
        status, output, errors = self.bytes_of(ply("one"), ply("one"))
        self.assertEqual(status, 0, errors)
        self.assertIn("0 differ, 0 failed", output)

    def test_comments_may_differ(self):
        status, output, errors = self.bytes_of(ply("one"), ply("one", comment="of another build"))
        self.assertEqual(status, 0, errors)
        self.assertIn("0 differ, 0 failed", output)

    def test_other_bytes_differ(self):
        status, output, _ = self.bytes_of(ply("one"), ply("two"), only="17-points --estimator=aso --k=50")
        self.assertEqual(status, 1)
        self.assertIn("4 results compared: 4 differ", output)

    def test_a_program_that_fails_alike_in_both_builds_is_a_failure(self):
        fail = "echo boom >&2; exit 3"
        status, output, _ = self.bytes_of(fail, fail, only="17-points --estimator=aso --k=50")
        self.assertEqual(status, 1)
        self.assertIn("exit 3: boom", output)
        self.assertIn("4 results compared: 0 differ, 4 failed", output)

    def test_no_case_is_a_failure(self):
        self.assertEqual(self.bytes_of(ply("one"), ply("one"), only="no such case")[0], 1)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
