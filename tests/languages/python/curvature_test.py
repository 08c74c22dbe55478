"""Curvature from a real curvd, as numpy arrays."""



import grpc
import numpy as np

from clouds import sphere
from curvd_client import RESULT_DTYPE, CurvdError, CurvdWarning, PointStatus, estimate_curvature
from real_server import RealServerTest


class CurvatureTest(RealServerTest):
    def test_sphere_has_the_curvature_of_a_sphere(self):
        positions, normals = sphere(20_000, radius=2.0)
        points, summary = estimate_curvature(positions, normals, server=self.server)
        self.assertEqual(points.dtype, RESULT_DTYPE)
        self.assertEqual(len(points), 20_000)
        self.assertEqual(summary.status_counts.ok, 20_000)
        self.assert_sphere(points, 2.0)
        np.testing.assert_allclose(np.einsum("ij,ij->i", np.cross(points["d1"], points["d2"]), normals), 1, atol=1e-3)

    def test_doubles_stay_exact_far_from_the_origin(self):
        positions, normals = sphere(20_000, radius=2.0, dtype=np.float64)
        points, _ = estimate_curvature(positions + 5e6, normals, server=self.server)
        self.assert_sphere(points, 2.0)

    def test_floats_far_from_the_origin_are_warned_of(self):
        positions, normals = sphere(20_000, radius=2.0)
        with self.assertWarns(CurvdWarning) as caught:
            estimate_curvature(positions + np.float32(5e6), normals, server=self.server, skip_invalid=True)
        self.assertEqual(caught.warning.code, "COARSE_POSITIONS")
        self.assertIn("Send doubles", str(caught.warning))

    def test_many_chunks_of_a_strided_view_arrive_in_order(self):
        positions, normals = sphere(100_000, radius=3.0)
        both = np.concatenate([positions, normals], axis=1)
        strided, _ = estimate_curvature(both[:, :3], both[:, 3:], server=self.server)
        packed, _ = estimate_curvature(positions, normals, server=self.server)
        self.assertEqual(strided.tobytes(), packed.tobytes())

    def test_options_reach_the_server(self):
        positions, normals = sphere(2_000, radius=1.0)
        points, _ = estimate_curvature(positions, normals, server=self.server, radius=0.25, estimator="hexagram")
        self.assertTrue(np.all(points["radius"] == 0.25))

    def test_only_what_was_asked_for_comes(self):
        positions, normals = sphere(40_000, radius=2.0)
        everything, _ = estimate_curvature(positions, normals, server=self.server)
        points, _ = estimate_curvature(
            positions, normals, server=self.server, quantities=["principal_directions", "mean_curvature"]
        )
        self.assertEqual(points.dtype.names, ("mean_curvature", "d1", "d2", "status"))
        for name in points.dtype.names:
            np.testing.assert_array_equal(points[name], everything[name])

    def test_unknown_quantities_are_refused_before_a_call(self):
        positions, normals = sphere(10, radius=1.0)
        for wrong in (["curl"], ["radius", "radius"], "radius", ["unspecified"]):
            with self.subTest(wrong), self.assertRaises(ValueError):
                estimate_curvature(positions, normals, server=self.server, quantities=wrong)

    def test_no_quantities_are_all_quantities(self):
        positions, normals = sphere(100, radius=1.0)
        everything, _ = estimate_curvature(positions, normals, server=self.server)
        for none in ([], (), None):
            points, _ = estimate_curvature(positions, normals, server=self.server, quantities=none)
            np.testing.assert_array_equal(points, everything)

    def test_every_estimator_has_a_name(self):
        positions, normals = sphere(20_000, radius=2.0)
        for estimator in ("avg-hexagram", "hexagram", "delaunay", "jet", "aso", "normal-regression"):
            with self.subTest(estimator):
                points, _ = estimate_curvature(positions, normals, server=self.server, estimator=estimator)
                self.assert_sphere(points, 2.0)
        for estimator in ("uniform", "independent"):
            with self.subTest(estimator):
                _, summary = estimate_curvature(positions, normals, server=self.server, estimator=estimator)
                self.assertEqual(summary.status_counts.ok, 20_000)

    def test_a_jet_needs_as_many_neighbors_as_coefficients(self):
        positions, normals = sphere(1_000, radius=2.0)
        for degree, status in ((2, PointStatus.OK), (4, PointStatus.SINGULAR_FIT)):
            points, summary = estimate_curvature(
                positions, normals, server=self.server, estimator="jet", jet_degree=degree, neighbor_count=14
            )
            self.assertTrue(np.all(points["status"] == status))
            self.assertEqual(summary.status_counts.singular_fit, 1_000 if degree == 4 else 0)

    def test_even_weights_reach_the_server(self):
        positions, normals = sphere(1_000, radius=2.0)
        positions[:, 2] *= 2  # an ellipsoid: on a sphere all triangles say the same
        delaunay = {"server": self.server, "estimator": "delaunay"}
        fading, _ = estimate_curvature(positions, normals, **delaunay)
        even, _ = estimate_curvature(positions, normals, even_weights=True, **delaunay)
        self.assertFalse(np.array_equal(fading["mean_curvature"], even["mean_curvature"]))

    def test_projecting_reaches_the_server(self):
        positions, normals = sphere(1_000, radius=2.0)
        positions[::50] *= 1.02
        aso = {"server": self.server, "estimator": "aso", "neighbor_count": 200}
        levels, _ = estimate_curvature(positions, normals, **aso)
        surface, _ = estimate_curvature(positions, normals, project=True, **aso)
        self.assertLess(np.std(surface["mean_curvature"]), np.std(levels["mean_curvature"]))

    def test_priorities_do_not_change_a_byte(self):
        positions, normals = sphere(1_000, radius=2.0)
        first, *others = (
            estimate_curvature(positions, normals, server=self.server, priority=priority).points.tobytes()
            for priority in (None, "interactive", "batch")
        )
        self.assertEqual(others, [first, first])

    def test_empty_cloud_gives_an_empty_result(self):
        points, summary = estimate_curvature(np.zeros((0, 3)), np.zeros((0, 3)), server=self.server)
        self.assertEqual((len(points), summary.point_count), (0, 0))

    def test_invalid_point_is_named_in_the_error(self):
        positions, normals = sphere(1_000, radius=1.0)
        positions[123, 1] = np.nan
        with self.assertRaises(CurvdError) as caught:
            estimate_curvature(positions, normals, server=self.server)
        self.assertEqual(caught.exception.code, grpc.StatusCode.INVALID_ARGUMENT)
        self.assertIn("123", caught.exception.message)
        self.assertNotEqual(caught.exception.reason, "")
        # What leads to the line in the server's log is in the message itself.
        self.assertIn(f"(request {caught.exception.metadata['request_id']})", str(caught.exception))

    def test_invalid_point_is_skipped_on_request(self):
        positions, normals = sphere(1_000, radius=1.0)
        positions[123, 1] = np.nan
        points, summary = estimate_curvature(positions, normals, server=self.server, skip_invalid=True)
        self.assertEqual(points["status"][123], PointStatus.INVALID_INPUT)
        self.assertTrue(np.isnan(points["mean_curvature"][123]))
        self.assertEqual(summary.status_counts.invalid_input, 1)

    def test_bad_option_is_refused(self):
        positions, normals = sphere(100, radius=1.0)
        with self.assertRaises(CurvdError) as caught:
            estimate_curvature(positions, normals, server=self.server, neighbor_count=2)
        self.assertEqual(caught.exception.code, grpc.StatusCode.INVALID_ARGUMENT)
        self.assertIn("neighbor_count", caught.exception.message)

    def test_deadline_ends_the_call(self):
        positions, normals = sphere(100_000, radius=1.0)
        with self.assertRaises(CurvdError) as caught:
            estimate_curvature(positions, normals, server=self.server, timeout=0.001)
        self.assertEqual(caught.exception.code, grpc.StatusCode.DEADLINE_EXCEEDED)
