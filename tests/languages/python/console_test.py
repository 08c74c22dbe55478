"""The command curvd-client, as a person types it."""

import contextlib
import io
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest
from unittest import mock

import numpy as np

from clouds import sphere
from curvd_client import console


class ConsoleTest(unittest.TestCase):
    def setUp(self):
        self.server = os.environ["CURVD_SERVER"]
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def run_command(self, *arguments, server=None):
        command = [sys.executable, "-m", "curvd_client.console", *map(str, arguments)]
        if arguments[0] != "--version":
            command.append(f"--server={server or self.server}")
        return subprocess.run(command, cwd=self.folder, capture_output=True, text=True, check=False, timeout=60)

    def test_each_kind_of_file_gives_the_same_curvature(self):
        positions, normals = sphere(2_000, radius=2.0)
        both = np.concatenate([positions, normals], axis=1)
        np.save(self.folder / "cloud.npy", both)
        np.savez(self.folder / "cloud.npz", points=positions, normals=normals)
        np.savetxt(self.folder / "cloud.xyz", both, fmt="%.9g", header="x y z nx ny nz")
        np.savetxt(self.folder / "cloud.csv", both, fmt="%.9g", delimiter=",")
        # As curv writes them: named columns, some of words, in CSV, and those of text in a comment.
        rows = "".join(f"{i},ok,{','.join(map(repr, row))}\n" for i, row in enumerate(both.tolist()))
        (self.folder / "named.csv").write_text('\ufeff"i",status,X,Y,Z,nx,ny,nz\n' + rows, encoding="utf-8")
        text = "".join(" ".join(map(repr, row)) + f" {i} ok\n" for i, row in enumerate(both.tolist()))
        (self.folder / "named.xyz").write_text("# x y z nx ny nz i status\n" + text, encoding="utf-8")
        # A column each.
        columns = dict(zip(("x", "y", "z", "nx", "ny", "nz"), both.T))
        np.savez(self.folder / "columns.npz", intensity=both[:, 0] * 0, **columns)
        structured = np.empty(len(both), [(name, np.float64) for name in columns])
        for name, values in columns.items():
            structured[name] = values
        np.save(self.folder / "columns.npy", structured)
        for name in ("cloud.npy", "cloud.npz", "cloud.xyz", "cloud.csv", "named.csv", "named.xyz", "columns.npz", "columns.npy"):
            kind = name.replace(".", "_")
            with self.subTest(kind):
                done = self.run_command("estimate", name, "-o", f"{kind}.npz", "--k=30")
                self.assertEqual((done.returncode, done.stderr), (0, ""))
                with np.load(self.folder / f"{kind}.npz") as result:
                    np.testing.assert_allclose(result["mean_curvature"], 0.5, rtol=0.02)
                    np.testing.assert_allclose(result["positions"], positions)

    def test_what_cannot_be_done_has_a_code_and_a_reason(self):
        np.save(self.folder / "cloud.npy", sphere(100, radius=1.0)[0])
        np.save(self.folder / "flat.npy", np.zeros((4, 2)))
        np.savez(self.folder / "other.npz", a=1)
        np.savez(self.folder / "uneven.npz", x=np.zeros(3), y=np.zeros(3), z=np.zeros(4))
        (self.folder / "bad.xyz").write_text("1 2 3\n4 five 6\n", encoding="utf-8")
        (self.folder / "damaged.npz").write_bytes(b"PK\x03\x04" + bytes(100))
        np.save(self.folder / "complex.npy", np.zeros((4, 3), dtype=complex))
        (self.folder / "cloud.las").write_bytes(b"LASF")
        # What has a name less than its lines have values would take the wrong values for x y z.
        (self.folder / "shifted.csv").write_text("x,y,z\n1,0.5,0.25,0.75\n", encoding="utf-8")
        (self.folder / "twice.csv").write_text("x,y,z,x\n1,2,3,4\n", encoding="utf-8")
        (self.folder / "empty.csv").write_text("", encoding="utf-8")
        (self.folder / "nothing.npy").write_bytes(b"")
        np.savez(self.folder / "none.npz", positions=np.zeros((0, 3)))
        (self.folder / "folder.npy").mkdir()
        (self.folder / "folder").mkdir()
        for code, words, arguments, server in (
            (1, "--k is 1000000; it must be at most 10000 (max_neighbor_count)", ["cloud.npy", "-o", "out.npz", "--k=1000000"], None),
            (2, "--k is [64, 16]; it must be a list", ["cloud.npy", "-o", "out.npz", "--k=64,16"], None),
            (2, "several numbers of --k exclude --radius and", ["cloud.npy", "-o", "out.npz", "--k=16,64", "--radius=1"], None),
            (2, "--quantities: 'mean' is unknown", ["cloud.npy", "-o", "out.npz", "--quantities=mean"], None),
            (2, "needs --direction", ["cloud.npy", "-o", "out.npz", "--quantities=normal_curvature"], None),
            (2, '"3" must be auto, or whole numbers from 4 to 1000000', ["cloud.npy", "-o", "out.npz", "--k=3"], None),
            (2, '"9,ten" must be', ["cloud.npy", "-o", "out.npz", "--k=9,ten"], None),
            (2, "--radius: \"nan\" must be a finite number above 0", ["cloud.npy", "-o", "out.npz", "--radius=nan"], None),
            (2, "--timeout: \"0\" must be", ["cloud.npy", "-o", "out.npz", "--timeout=0"], None),
            (2, "--direction: \"1,2\" must be three", ["cloud.npy", "-o", "out.npz", "--direction=1,2"], None),
            (2, "--tls-ca: none.pem: No such file", ["cloud.npy", "-o", "out.npz", "--tls-ca=none.pem"], None),
            (2, "--token-file: empty.csv holds no token",
             ["cloud.npy", "-o", "out.npz", "--token-file=empty.csv"], None),
            (2, "--token-file: the token must be printable",
             ["cloud.npy", "-o", "out.npz", "--token-file=bad.xyz"], None),
            (2, "--token-file: none: No such file", ["cloud.npy", "-o", "out.npz", "--token-file=none"], None),
            (2, "--tls-ca: no certificate can be read from bad.xyz",
             ["cloud.npy", "-o", "out.npz", "--tls-ca=bad.xyz"], None),
            (2, "--tls-cert and --tls-key are of use together only",
             ["cloud.npy", "-o", "out.npz", "--tls-cert=bad.xyz"], None),
            (2, "do not hold a certificate and its private key",
             ["cloud.npy", "-o", "out.npz", "--tls-cert=bad.xyz", "--tls-key=bad.xyz"], None),
            (2, "must end in .npz", ["cloud.npy", "-o", "out.ply"], None),
            (2, "would replace the input", ["other.npz", "-o", "./other.npz"], None),
            (2, "--k and --radius exclude each other", ["cloud.npy", "-o", "out.npz", "--k=9", "--radius=1"], None),
            (2, "invalid choice", ["cloud.npy", "-o", "out.npz", "--estimator=best"], None),
            (3, "damaged.npz: numpy cannot read it", ["damaged.npz", "-o", "out.npz"], None),
            (3, "complex128", ["complex.npy", "-o", "out.npz"], None),
            (3, "(N, 3)", ["flat.npy", "-o", "out.npz"], None),
            (3, "there must be positions or points or xyz, or x and y and z", ["other.npz", "-o", "out.npz"], None),
            (3, "all must be (N,)", ["uneven.npz", "-o", "out.npz"], None),
            (3, "five", ["bad.xyz", "-o", "out.npz"], None),
            (3, "line 2 has 4 values, and there are 3 columns", ["shifted.csv", "-o", "out.npz"], None),
            (3, "two columns have the name x", ["twice.csv", "-o", "out.npz"], None),
            (3, "no points", ["empty.csv", "-o", "out.npz"], None),
            (3, "no kind that is read", ["cloud.las", "-o", "out.npz"], None),
            (3, "No such file", ["none.npy", "-o", "out.npz"], None),
            (3, "nothing.npy: the file is empty", ["nothing.npy", "-o", "out.npz"], None),
            (3, "none.npz: it holds no points", ["none.npz", "-o", "out.npz"], None),
            (3, "folder.npy: it is a directory", ["folder.npy", "-o", "out.npz"], None),
            (3, "folder: it is a directory", ["folder", "-o", "out.npz"], None),
            (3, "no normals", ["cloud.npy", "-o", "out.npz", "--normals=given"], None),
            (4, "No such file", ["cloud.npy", "-o", "nowhere/out.npz"], None),
            (6, "the call took longer than --timeout allows", ["cloud.npy", "-o", "out.npz", "--timeout=0.000001"], None),
            (5, "UNAVAILABLE", ["cloud.npy", "-o", "out.npz"], "127.0.0.1:1"),
        ):
            with self.subTest(arguments):
                done = self.run_command("estimate", *arguments, server=server)
                self.assertEqual(done.returncode, code, done.stderr)
                self.assertIn(words, done.stderr)
                self.assertNotIn("Traceback", done.stderr)
                self.assertEqual(list(self.folder.glob("out*")), [])

    def test_a_server_that_does_not_serve_is_none(self):
        with mock.patch("curvd_client.console.CurvatureClient") as client, contextlib.redirect_stdout(io.StringIO()) as out:
            client.return_value.__enter__.return_value.health.return_value = "NOT_SERVING"
            self.assertEqual(console.main(["health"]), 5)
        self.assertEqual(out.getvalue(), "NOT_SERVING\n")

    def test_the_package_is_the_command(self):
        done = subprocess.run([sys.executable, "-m", "curvd_client", "--version"], capture_output=True, text=True, check=False)
        self.assertEqual((done.returncode, done.stdout.split()[0]), (0, "curvd-client"), done.stderr)

    def test_one_point_is_no_points(self):
        np.save(self.folder / "one.npy", np.zeros((1, 6)) + 1)
        done = self.run_command("estimate", "one.npy", "-o", "out.npz")
        self.assertEqual(done.stdout, "1 point, 0 estimated: out.npz\n")

    def test_info_and_health(self):
        info = json.loads(self.run_command("info").stdout)
        self.assertIn("avg-hexagram", info["estimators"])
        self.assertGreater(info["limits"]["max_points"], 0)
        self.assertEqual(self.run_command("health").stdout, "SERVING\n")
        self.assertEqual(self.run_command("health", server="127.0.0.1:1").returncode, 5)
