"""Normals that a real curvd makes or turns."""

import pathlib

import numpy as np

from clouds import sphere
from curvd_client import (
    RESULT_DTYPE,
    CurvdError,
    CurvdWarning,
    PointStatus,
    estimate_curvature,
    estimate_normals,
)
from curvd_client import curvature_pb2 as pb
from real_server import RealServerTest


class NormalsTest(RealServerTest):
    def test_opposed_normals_are_warned_of_or_refused(self):
        positions, normals = sphere(2_000, radius=2.0)
        normals[:1_000] *= -1
        with self.assertWarns(CurvdWarning) as caught:
            points, summary = estimate_curvature(positions, normals, server=self.server)
        self.assertEqual(caught.warning.code, "OPPOSED_NORMALS")
        self.assertIn("make all normals point to one side", str(caught.warning))
        self.assertEqual(pathlib.Path(caught.filename).name, pathlib.Path(__file__).name)
        self.assertEqual(summary.warnings[0].point_count, np.sum(points["status"] == PointStatus.OPPOSED_NORMALS))
        self.assertGreater(summary.warnings[0].point_count, 0)
        self.assertEqual(summary.warnings[0].flipped_patch_count, 1)
        with self.assertRaises(CurvdError) as refused:
            estimate_curvature(positions, normals, server=self.server, reject_opposed_normals=True)
        self.assertEqual(refused.exception.reason, "OPPOSED_NORMALS")

    def test_a_cloud_without_normals_gets_them(self):
        positions, normals = sphere(20_000, radius=2.0)
        points, summary = estimate_curvature(positions, server=self.server)
        self.assertEqual(points.dtype.names, (*RESULT_DTYPE.names[:-1], "normal", "status"))
        self.assert_sphere(points, 2.0)
        np.testing.assert_allclose(points["normal"], normals, atol=0.01)
        self.assertEqual(summary.normals.closed_piece_count, 1)
        self.assertLess(summary.normals.certificate, 0.25)
        some, _ = estimate_curvature(positions, server=self.server, quantities=["mean_curvature"])
        self.assertEqual(some.dtype.names, ("mean_curvature", "status"))
        np.testing.assert_array_equal(some["mean_curvature"], points["mean_curvature"])

    def test_given_normals_are_turned_only_if_a_side_is_asked_for(self):
        positions, normals = sphere(2_000, radius=2.0)
        inward = -normals
        given, _ = estimate_curvature(positions, inward, server=self.server)
        self.assertEqual(given.dtype, RESULT_DTYPE)
        self.assertLess(np.median(given["mean_curvature"]), 0)
        for side in ({"orientation": "consistent"}, {"orientation": "closed"}):
            turned, summary = estimate_curvature(positions, inward, server=self.server, **side)
            np.testing.assert_allclose(turned["normal"], normals, atol=1e-6)
            self.assertGreater(np.median(turned["mean_curvature"]), 0)
            self.assertEqual(summary.normals.turned_count, 2_000)

    def test_normals_alone_have_quality_and_no_curvature(self):
        positions, normals = sphere(2_000, radius=2.0, dtype=np.float64)
        positions += [5e5, 5e6, 100.0]
        points, summary = estimate_normals(positions, server=self.server, method="pca", neighbor_count=12)
        self.assertEqual(points.dtype.names, ("normal", "normal_residual", "normal_variance_ratio", "status"))
        np.testing.assert_allclose(points["normal"], normals, atol=0.05)
        self.assertTrue(np.all(points["normal_residual"] < 0.2))
        self.assertEqual(summary.normals.method, pb.NORMAL_METHOD_PCA)
        self.assertEqual(summary.normals.neighbor_count, 12)
        self.assertEqual(summary.seconds.estimate, 0)
        turned, _ = estimate_normals(positions, -normals, server=self.server, orientation="closed")
        np.testing.assert_allclose(turned["normal"], normals, atol=1e-6)
        self.assertTrue(np.all(np.isnan(turned["normal_residual"])))

    def test_sides_follow_viewpoints_and_directions(self):
        positions, normals = sphere(2_000, radius=2.0)
        ask = {"server": self.server, "neighbor_count": 12}
        inside, _ = estimate_normals(positions, viewpoint=[0, 0, 0], **ask)
        np.testing.assert_allclose(inside["normal"], -normals, atol=0.1)
        outside = 3 * positions
        seen, _ = estimate_normals(positions, viewpoint=outside, **ask)
        np.testing.assert_allclose(seen["normal"], normals, atol=0.1)
        down, _ = estimate_normals(positions, direction=(0, 0, -1), **ask)
        self.assertTrue(np.all(down["normal"][:, 2] <= 0))

    def test_sides_that_cannot_be_trusted_are_warned_of(self):
        # A Moebius strip, which has one side alone.
        random = np.random.default_rng(4)
        around, across = random.uniform(0, 2 * np.pi, 4_000), random.uniform(-0.4, 0.4, 4_000)
        radius = 1 + across * np.cos(around / 2)
        strip = np.stack([radius * np.cos(around), radius * np.sin(around), across * np.sin(around / 2)], axis=1)
        with self.assertWarns(CurvdWarning) as caught:
            _, summary = estimate_normals(strip, server=self.server, orientation="closed")
        self.assertEqual(caught.warning.code, "DOUBTFUL_ORIENTATION")
        self.assertEqual(pathlib.Path(caught.filename).name, pathlib.Path(__file__).name)
        self.assertTrue(summary.normals.doubtful)

    def test_arguments_for_normals_that_make_no_sense_are_refused_before_a_call(self):
        positions, normals = sphere(10, radius=1.0)
        for word, wrong in (
            ("exclude", {"orientation": "closed", "direction": (0, 0, 1)}),
            ("orientation is 'up'", {"orientation": "up"}),
            ("viewpoint has shape (2,)", {"viewpoint": (1, 2)}),
            ("10 positions but 9 viewpoints", {"viewpoint": positions[:9]}),
            ("goes with normals=None", {"normals": normals, "method": "pca"}),
            ("method of normals is 'best'", {"method": "best"}),
            ("exclude", {"neighbor_count": 10, "radius": 1.0}),
        ):
            with self.subTest(wrong), self.assertRaises(ValueError) as refused:
                estimate_normals(positions, server=self.server, **wrong)
            self.assertIn(word, str(refused.exception))

    def test_a_viewpoint_that_is_no_place_is_named(self):
        positions, _ = sphere(10, radius=1.0)
        with self.assertRaises(CurvdError) as refused:
            estimate_normals(positions, server=self.server, viewpoint=(0, float("nan"), 0))
        self.assertEqual(refused.exception.reason, "INVALID_OPTION")
        self.assertIn("header.normals.viewpoint", refused.exception.message)
