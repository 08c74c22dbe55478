"""What is left to the server: estimator and size of neighborhoods."""



import numpy as np

from clouds import sphere
from curvd_client import DEFAULT_QUANTITIES, CurvdError, PointStatus, estimate_curvature, estimate_normals
from curvd_client import curvature_pb2 as pb
from real_server import RealServerTest


class ScaleTest(RealServerTest):
    def test_auto_chooses_what_suits_the_cloud(self):
        positions, normals = sphere(10_000, radius=2.0)
        positions += np.random.default_rng(1).normal(scale=0.01, size=positions.shape).astype(np.float32)
        error = {}
        for estimator in ("auto", "avg-hexagram"):
            points, summary = estimate_curvature(positions, normals, server=self.server, estimator=estimator)
            self.assertEqual(summary.status_counts.ok, 10_000)
            error[estimator] = np.mean(np.abs(points["mean_curvature"] - 0.5))
            self.assertEqual(summary.HasField("scale"), estimator == "auto")
            if estimator == "auto":
                self.assertAlmostEqual(sum(outcome.share for outcome in summary.scale.outcomes), 1)
                self.assertAlmostEqual(summary.scale.position_noise, 0.01, delta=0.002)
        self.assertLess(error["auto"], 0.7 * error["avg-hexagram"])

    def test_estimator_or_scale_alone_may_be_left_open(self):
        cloud = sphere(5_000, radius=2.0)
        _, summary = estimate_curvature(
            *cloud, server=self.server, estimator="jet", neighbor_count="auto", neighbor_count_range=(64, 128)
        )
        outcomes = {(each.estimator, each.neighbor_count) for each in summary.scale.outcomes}
        self.assertEqual(outcomes, {(pb.ESTIMATOR_JET_FITTING, count) for count in (64, 91, 128)})
        _, summary = estimate_curvature(*cloud, server=self.server, estimator="auto", neighbor_count=100)
        self.assertEqual({each.neighbor_count for each in summary.scale.outcomes}, {100})

    def test_no_estimate_looks_farther_than_max_radius(self):
        cloud = sphere(5_000, radius=2.0)
        points, _ = estimate_curvature(*cloud, server=self.server, estimator="auto", max_radius=0.3)
        is_ok = points["status"] == PointStatus.OK
        self.assertGreater(np.sum(is_ok), 4_000)
        self.assertLessEqual(np.max(points["radius"][is_ok]), 0.3)
        points, _ = estimate_curvature(*cloud, server=self.server, estimator="auto", max_radius=1e-6)
        self.assertTrue(np.all(points["status"] == PointStatus.TOO_FEW_NEIGHBORS))

    def test_one_choice_for_the_whole_cloud_differs(self):
        positions, normals = sphere(5_000, radius=2.0)
        noise = np.random.default_rng(2).normal(scale=0.02, size=positions.shape)
        positions += np.where(positions[:, 2:] > 0, noise, 0).astype(np.float32)
        auto = {"server": self.server, "estimator": "auto"}
        each, _ = estimate_curvature(positions, normals, **auto)
        all_alike, _ = estimate_curvature(positions, normals, scale_per_cloud=True, **auto)
        self.assertFalse(np.array_equal(each["mean_curvature"], all_alike["mean_curvature"]))

    def test_values_come_with_how_sure_they_are(self):
        positions, normals = sphere(10_000, radius=2.0)
        positions += np.random.default_rng(3).normal(scale=0.02, size=positions.shape).astype(np.float32)
        quantities = [*DEFAULT_QUANTITIES, "standard_errors", "chosen_neighbor_count", "estimator_weights"]
        points, summary = estimate_curvature(
            positions, normals, server=self.server, estimator="auto", quantities=quantities
        )
        within = np.abs(points["mean_curvature"] - 0.5) <= 1.645 * points["mean_curvature_standard_error"]
        self.assertGreater(np.mean(within), 0.8)
        self.assertTrue(np.all(points["k1_standard_error"] > 0) and np.all(points["k2_standard_error"] > 0))
        self.assertTrue(np.all((points["chosen_neighbor_count"] >= 16) & (points["chosen_neighbor_count"] <= 2048)))
        weights = sum(points[f"{name}_weight"] for name in ("avg_hexagram", "normal_regression", "jet", "aso"))
        np.testing.assert_allclose(weights, 1, rtol=1e-5)
        self.assertTrue(summary.scale.HasField("normal_noise"))
        self.assertFalse(summary.scale.HasField("fitted_normals"))

    def test_normals_of_planes_are_known_again(self):
        positions, _ = sphere(10_000, radius=2.0)
        positions += np.random.default_rng(3).normal(scale=0.02, size=positions.shape).astype(np.float32)
        made, _ = estimate_normals(positions, method="pca", neighbor_count=30, server=self.server)
        _, summary = estimate_curvature(positions, made["normal"], server=self.server, estimator="auto")
        self.assertEqual(summary.scale.fitted_normals.neighbor_count, 30)
        self.assertGreater(summary.scale.normals_made_anew.neighbor_count, 30)

    def test_normal_curvature_takes_one_direction_or_one_for_each_point(self):
        positions, normals = sphere(2_000, radius=2.0)
        asked = {"server": self.server, "quantities": ["normal_curvature"]}
        points, _ = estimate_curvature(positions, normals, curvature_direction=[0, 0, 1], **asked)
        self.assertAlmostEqual(np.nanmedian(points["normal_curvature"]), 0.5, delta=0.01)
        directions = np.where(np.arange(2_000)[:, None] < 1_000, [0, 0, 0], [0, 0, 3])
        points, _ = estimate_curvature(positions, normals, curvature_direction=directions, **asked)
        self.assertTrue(np.all(np.isnan(points["normal_curvature"][:1_000])))
        self.assertAlmostEqual(np.nanmedian(points["normal_curvature"][1_000:]), 0.5, delta=0.01)
        with self.assertRaisesRegex(ValueError, "needs a curvature_direction"):
            estimate_curvature(positions, normals, **asked)
        with self.assertRaisesRegex(ValueError, "normal_curvature"):
            estimate_curvature(positions, normals, server=self.server, curvature_direction=[0, 0, 1])
        with self.assertRaisesRegex(ValueError, "curvature_directions has shape"):
            estimate_curvature(positions, normals, curvature_direction=np.ones((2_000, 2)), **asked)

    def test_scales_that_the_server_refuses_are_named(self):
        cloud = sphere(100, radius=1.0)
        for words, options in (
            ("it must be auto, avg-hexagram", {"estimator": "hexagram", "neighbor_count": "auto"}),
            ("jet_degree is 2; it must be 4", {"estimator": "jet", "neighbor_count": "auto", "jet_degree": 2}),
            ("least_neighbor_count is 15; it must be from 16", {"estimator": "auto", "neighbor_count_range": (15, 64)}),
            ("max_radius is inf", {"estimator": "auto", "max_radius": float("inf")}),
        ):
            with self.subTest(options), self.assertRaises(CurvdError) as refused:
                estimate_curvature(*cloud, server=self.server, **options)
            self.assertEqual(refused.exception.reason, "INVALID_OPTION")
            self.assertIn(words, refused.exception.message)
