"""Several neighbor counts in one call."""

import numpy as np

from clouds import sphere
from curvd_client import CurvdError, PointStatus, estimate_curvature
from curvd_client import curvature_pb2 as pb
from curvd_client.results import ResultCollector
from real_server import RealServerTest


class ScalesTest(RealServerTest):
    def test_each_count_has_the_bytes_of_a_call_of_its_own(self):
        positions, normals = sphere(20_000, radius=2.0)  # more points than one ResultChunk holds
        positions += np.random.default_rng(1).normal(scale=0.01, size=positions.shape).astype(np.float32)
        counts = [16, 60, 300]
        for estimator in ("avg-hexagram", "normal-regression"):
            asked = {"server": self.server, "estimator": estimator}
            points, summary = estimate_curvature(positions, normals, neighbor_counts=counts, **asked)
            self.assertEqual(summary.point_count, 20_000)
            self.assertEqual(summary.status_counts.ok, sum(np.sum(points[f"status_k{k}"] == 1) for k in counts))
            for count in counts:
                alone, _ = estimate_curvature(positions, normals, neighbor_count=count, **asked)
                for name in alone.dtype.names:
                    np.testing.assert_array_equal(points[f"{name}_k{count}"], alone[name])
            self.assertEqual(len(points.dtype.names), len(counts) * len(alone.dtype.names))

    def test_a_cloud_may_be_too_small_for_the_larger_counts_alone(self):
        points, summary = estimate_curvature(*sphere(100, radius=1.0), server=self.server, neighbor_counts=[20, 200])
        self.assertTrue(np.all(points["status_k20"] == PointStatus.OK))
        self.assertTrue(np.all(points["status_k200"] == PointStatus.TOO_FEW_NEIGHBORS))
        self.assertTrue(np.all(np.isnan(points["mean_curvature_k200"])))
        self.assertEqual((summary.status_counts.ok, summary.status_counts.too_few_neighbors), (100, 100))

    def test_normals_come_once(self):
        positions, _ = sphere(1_000, radius=1.0)
        points, _ = estimate_curvature(positions, server=self.server, neighbor_counts=[16, 32])
        self.assertEqual(points["normal"].shape, (1_000, 3))
        self.assertNotIn("normal_k16", points.dtype.names)
        asked = {"server": self.server, "neighbor_counts": [16, 32], "quantities": ["curvedness"]}
        points, _ = estimate_curvature(positions, **asked)
        self.assertEqual(points.dtype.names, ("curvedness_k16", "status_k16", "curvedness_k32", "status_k32"))

    def test_an_empty_cloud_and_one_count_are_fine(self):
        empty = np.zeros((0, 3), np.float32)
        points, _ = estimate_curvature(empty, empty, server=self.server, neighbor_counts=[16, 32])
        self.assertEqual((len(points), "status_k32" in points.dtype.names), (0, True))
        points, _ = estimate_curvature(*sphere(100, radius=1.0), server=self.server, neighbor_counts=[16])
        self.assertTrue(np.all(points["status_k16"] == PointStatus.OK))

    def test_counts_that_make_no_request_are_named(self):
        cloud = sphere(100, radius=1.0)
        for words, options in (
            ("must be a list of numbers that ascend", {"neighbor_counts": [32, 16]}),
            ("must be a list of numbers that ascend", {"neighbor_counts": [16, 16]}),
            ("must be a list of numbers that ascend", {"neighbor_counts": []}),
            ("exclude neighbor_count", {"neighbor_counts": [16], "neighbor_count": 16}),
            ("exclude neighbor_count", {"neighbor_counts": [16], "radius": 1.0}),
            ("exclude neighbor_count", {"neighbor_counts": [16], "estimator": "auto"}),
        ):
            with self.subTest(options), self.assertRaisesRegex(ValueError, words):
                estimate_curvature(*cloud, server=self.server, **options)

    def test_counts_that_the_server_refuses_are_named(self):
        cloud = sphere(100, radius=1.0)
        for reason, words, options in (
            ("INVALID_OPTION", "neighbor_counts\\[0\\] is 3; it must be at least 4", {"neighbor_counts": [3, 16]}),
            ("INVALID_OPTION", "a list of 17; it must be a list of at most 16", {"neighbor_counts": range(4, 21)}),
            ("INVALID_OPTION", "estimator is jet; it must be one of avg-hexagram, normal-regression",
             {"neighbor_counts": [16, 32], "estimator": "jet"}),
            ("INVALID_OPTION", "neighbor_counts is a list of 2; it must be a list of one where header.quantities has 10",
             {"neighbor_counts": [16, 32], "quantities": ["standard_errors"]}),
            ("INVALID_OPTION", "neighbor_counts is set; it must be unset unless",
             {"neighbor_counts": [16, 32], "quantities": ["normals"]}),
            ("NEIGHBORHOOD_TOO_LARGE", "neighbor_counts\\[1\\] is 10001", {"neighbor_counts": [16, 10_001]}),
        ):  # fmt: skip
            with self.subTest(options), self.assertRaisesRegex(CurvdError, words) as refused:
                estimate_curvature(*cloud, server=self.server, **options)
            self.assertEqual(refused.exception.reason, reason)

    def test_a_scale_that_is_missing_or_another_one_is_noticed(self):
        def chunk(count):
            return pb.ResultChunk(first_index=0, point_count=1, status=b"\1", neighbor_count=count)

        collector = ResultCollector(1, neighbor_counts=[16, 32])
        with self.assertRaisesRegex(ValueError, "results of 32 neighbors came, not of 16"):
            collector.add(chunk(32))
        collector.add(chunk(16))
        with self.assertRaisesRegex(ValueError, "no results of 32 neighbors came"):
            collector.finish(pb.Summary(point_count=1))
        collector.add(chunk(32))
        collector.finish(pb.Summary(point_count=1))
