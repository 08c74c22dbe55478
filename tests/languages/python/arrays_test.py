"""What numpy arrays make a cloud, and what a result can be turned into."""

import unittest

import numpy as np
import pandas

from clouds import sphere
from curvd_client import PointStatus, estimate_curvature, estimate_normals
from curvd_client.clouds import pack_cloud
from real_server import RealServerTest


class ArraysTest(unittest.TestCase):
    def test_any_order_and_strides_are_the_same_cloud(self):
        positions = np.arange(30, dtype=np.float32).reshape(10, 3)
        expected = positions.tobytes()
        for name, same in {
            "columns first": np.asfortranarray(positions),
            "big-endian": positions.astype(">f4"),
            "every other": np.repeat(positions, 2, axis=0)[::2],
            "backwards": positions[::-1].copy()[::-1],
            "read only": np.frombuffer(expected, np.float32).reshape(10, 3),
            "transpose": positions.T.copy().T,
        }.items():
            with self.subTest(name):
                packed = pack_cloud(same, None, None)["positions"]
                self.assertEqual((packed.dtype.str, packed.tobytes()), ("<f4", expected))

    def test_no_dtype_loses_a_digit(self):
        for dtype, sent in (
            ("f2", "<f4"), ("i1", "<f4"), ("u2", "<f4"), ("<f4", "<f4"), ("i4", "<f8"), ("u8", "<f8"), (">f8", "<f8"),
        ):  # fmt: skip
            with self.subTest(dtype):
                value = 2**24 + 1 if sent == "<f8" else 100
                packed = pack_cloud(np.full((2, 3), value, dtype), None, None)["positions"]
                self.assertEqual((packed.dtype.str, packed[0, 0]), (sent, value))
        self.assertEqual(pack_cloud([[1, 2, 3], [4, 5, 6]], None, None)["positions"].tolist()[1], [4, 5, 6])

    def test_what_is_no_cloud_is_named(self):
        good = np.zeros((4, 3))
        masked = np.ma.masked_less(np.array([[1.0, 2.0, -3.0]] * 4), 0)
        for words, positions, normals in (
            ("positions has dtype complex128", good * 1j, None),
            ("positions has dtype object", good.astype(object), None),
            ("positions has dtype bool", good > 0, None),
            ("positions has dtype <U", [["1", "2", "3"]], None),
            ("positions cannot be made an array", [[1, 2, 3], [4, 5]], None),
            ("positions has masked elements", masked, None),
            ("positions is None", None, None),
            ("positions has the type generator; it must be an array", (row for row in good), None),
            ("positions has the type str; it must be an array", "scan.npy", None),
            ("normals has the type dict; it must be an array", good, {"normals": good}),
            ("positions has shape (12,); it must be (N, 3); .reshape(-1, 3)", np.zeros(12), None),
            ("positions has shape (3, 4); it must be (N, 3); its transpose", good.T, None),
            ("positions has shape (1, 4, 3)", good[None], None),
            ("positions has shape ()", 1.0, None),
            ("normals has shape (4, 2)", good, good[:, :2]),
            ("4 positions but 3 normals", good, good[:3]),
            ("normals has values beyond what float32 holds", good.astype("f4"), good + 1e39),
        ):
            with self.subTest(words), self.assertRaises(ValueError) as refused:
                estimate_curvature(positions, normals, server="127.0.0.1:1")
            self.assertIn(words, str(refused.exception))

    def test_objects_that_make_no_array_are_named(self):
        class Tensor:
            def __array__(self, dtype=None):
                raise RuntimeError("call detach first")

        with self.assertRaisesRegex(ValueError, "positions cannot be made an array .*: call detach first"):
            estimate_curvature(Tensor(), server="127.0.0.1:1")
        with self.assertRaisesRegex(ValueError, "viewpoint cannot be made an array .*: call detach first"):
            estimate_curvature(np.zeros((4, 3)), server="127.0.0.1:1", viewpoint=Tensor())

    def test_nullable_data_frames_are_told_what_helps(self):
        frame = pandas.DataFrame(np.arange(6.0).reshape(2, 3)).astype("Float64")
        frame.iloc[0, 0] = pandas.NA
        with self.assertRaisesRegex(ValueError, r"positions has dtype object; .*\.to_numpy\(dtype=float, na_value=numpy.nan\)"):
            pack_cloud(frame, None)
        packed = pack_cloud(frame.to_numpy(dtype=float, na_value=np.nan), None)["positions"]
        np.testing.assert_array_equal(packed, [[np.nan, 1, 2], [3, 4, 5]])

    def test_unknown_options_are_refused(self):
        with self.assertRaisesRegex(TypeError, "no option neighbour_count; did you mean neighbor_count?"):
            estimate_curvature(np.zeros((4, 3)), server="127.0.0.1:1", neighbour_count=5)

    def test_options_of_other_types_are_refused(self):
        for kind, words, options in (
            (ValueError, "skip_invalid is 'no'; it must be True or False", {"skip_invalid": "no"}),
            (ValueError, "project is 1; it must be True or False", {"project": 1}),
            (ValueError, "request_tag is 5; it must be text", {"request_tag": 5}),
            (TypeError, "security is of type dict; it must be", {"security": {"tls": True}}),
        ):
            with self.subTest(words), self.assertRaisesRegex(kind, words):
                estimate_curvature(np.zeros((4, 3)), server="127.0.0.1:1", **options)


class ResultTest(RealServerTest):
    def test_integers_and_both_byte_orders_give_the_same_result(self):
        positions, normals = sphere(2_000, radius=2.0)
        positions = np.round(positions * 1000).astype(np.int16)
        expected = estimate_curvature(positions.astype(np.float32), normals, server=self.server).points.tobytes()
        for same in (positions, np.asfortranarray(positions), positions.astype(">i2"), positions.astype(">f4")):
            points, _ = estimate_curvature(same, normals.astype(">f8"), server=self.server)
            self.assertEqual(points.tobytes(), expected)

    def test_a_data_frame_has_a_row_a_point(self):
        positions, normals = sphere(500, radius=2.0)
        positions[7] = np.nan
        estimate = estimate_curvature(positions, normals, server=self.server, skip_invalid=True)
        frame = estimate.to_dataframe()
        self.assertEqual(len(frame), 500)
        self.assertEqual(list(frame.columns[:3]), ["mean_curvature", "gaussian_curvature", "k1"])
        self.assertEqual(frame["status"][7], PointStatus.INVALID_INPUT.name)
        self.assertEqual((frame["status"] == "OK").sum(), 499)
        np.testing.assert_array_equal(frame[["d1_x", "d1_y", "d1_z"]].to_numpy(), estimate.points["d1"])
        normals_frame = estimate_normals(positions, server=self.server, skip_invalid=True).to_dataframe()
        self.assertIn("normal_z", normals_frame.columns)
