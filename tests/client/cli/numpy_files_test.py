#!/usr/bin/python3
"""Files that numpy writes go through curv, and numpy reads what comes out: numpy_files_test.py CURV"""

import pathlib
import subprocess
import sys
import tempfile
import unittest
import warnings

import numpy as np

CURV = sys.argv.pop(1)
POINTS = 1500


def cloud():
    """A torus of radii 3 and 1, with its normals."""
    u, v = np.arange(POINTS) * 2.39996, np.arange(POINTS) * 0.7548777
    normals = np.stack([np.cos(u) * np.cos(v), np.sin(u) * np.cos(v), np.sin(v)], axis=1)
    return 3 * np.stack([np.cos(u), np.sin(u), 0 * u], axis=1) + normals, normals


class NumpyFiles(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.positions, self.normals = cloud()
        self.array = np.hstack([self.positions, self.normals])

    def estimate(self, name, out="out.npy"):
        run = subprocess.run([CURV, "estimate", self.folder / name, "-o", self.folder / out, "--k=30"],
                             capture_output=True, text=True, check=False)
        self.assertEqual(run.returncode, 0, run.stderr)
        return np.load(self.folder / out)

    def test_every_type_and_order_gives_the_same(self):
        np.save(self.folder / "plain.npy", self.array)
        expected = self.estimate("plain.npy")
        self.assertEqual(expected.shape, (POINTS,))
        self.assertEqual(expected["x"].dtype, np.float64)
        np.testing.assert_array_equal(expected["x"], self.positions[:, 0])
        self.assertTrue((expected["status"] == 1).all())
        for kind in ("<f8", ">f8"):
            for order in ("C", "F"):
                np.save(self.folder / "other.npy", np.array(self.array, dtype=kind, order=order))
                np.testing.assert_array_equal(self.estimate("other.npy"), expected)
        singles = self.array.astype("<f4")
        np.save(self.folder / "singles.npy", singles)
        expected_of_singles = self.estimate("singles.npy")
        np.testing.assert_allclose(expected_of_singles["k2"], expected["k2"], rtol=1e-3)
        np.save(self.folder / "other.npy", np.asfortranarray(singles.astype(">f4")))
        np.testing.assert_array_equal(self.estimate("other.npy"), expected_of_singles)

    def test_structures_and_archives_give_the_same(self):
        np.save(self.folder / "plain.npy", self.array)
        expected = self.estimate("plain.npy")
        names = ["x", "y", "z", "nx", "ny", "nz"]
        fields = np.zeros(POINTS, dtype=np.dtype([*[(name, ">f8") for name in names], ("scan", "<u2")], align=True))
        for column, name in enumerate(names):
            fields[name] = self.array[:, column]
        fields["scan"] = np.arange(POINTS)
        np.save(self.folder / "fields.npy", fields)
        result = self.estimate("fields.npy")
        np.testing.assert_array_equal(result["scan"], fields["scan"])
        vectors = np.zeros(POINTS, dtype=[("position", "<f8", (3,)), ("normal", "<f8", (3,))])
        vectors["position"], vectors["normal"] = self.positions, self.normals
        np.save(self.folder / "vectors.npy", vectors)
        np.savez(self.folder / "stored.npz", positions=self.positions, normals=self.normals)
        np.savez_compressed(self.folder / "deflated.npz", **{name: self.array[:, i] for i, name in enumerate(names)})
        for name in ("fields.npy", "vectors.npy", "stored.npz", "deflated.npz"):
            other = self.estimate(name)
            for column in expected.dtype.names:
                np.testing.assert_array_equal(other[column], expected[column], f"{name}: {column}")

    def test_an_archive_has_every_column(self):
        np.save(self.folder / "plain.npy", self.array)
        expected = self.estimate("plain.npy")
        with self.estimate("plain.npy", "out.npz") as archive:
            self.assertEqual(archive.files, list(expected.dtype.names))
            for column in archive.files:
                np.testing.assert_array_equal(archive[column], expected[column])
                self.assertEqual(archive[column].dtype, expected[column].dtype)
        result = self.estimate("out.npz")
        np.testing.assert_array_equal(result, expected)

    def test_names_of_any_language_come_back_and_others_are_made_ones(self):
        given = ["H\u00f6he", "\u66f2\u7387", "echo width", "it's", 'it"s', "a/b"]
        kept = ["H\u00f6he", "\u66f2\u7387", "echo width", "it_s", "it_s_2", "a_b"]
        fields = np.zeros(POINTS, dtype=[*[(name, "<f8") for name in ("x", "y", "z", "nx", "ny", "nz")],
                                         *[(name, "<u2") for name in given]])
        for column, name in enumerate(fields.dtype.names[:6]):
            fields[name] = self.array[:, column]
        for number, name in enumerate(given):
            fields[name] = number
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # numpy says that older ones do not read such names
            np.save(self.folder / "fields.npy", fields)
        for out in ("out.npy", "out.npz"):
            result = self.estimate("fields.npy", out)
            names = result.dtype.names if out == "out.npy" else result.files
            self.assertEqual([name for name in names if name in kept], kept)
            for number, name in enumerate(kept):
                self.assertTrue((result[name] == number).all(), name)


if __name__ == "__main__":
    unittest.main()
