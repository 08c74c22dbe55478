"""What is refused before a call."""

import unittest

import grpc
import numpy as np

from clouds import sphere
from curvd_client import CurvdError, estimate_curvature


class ArgumentTest(unittest.TestCase):
    def test_arrays_that_make_no_cloud_are_refused(self):
        for positions, normals in [
            (np.zeros((4, 2)), np.zeros((4, 2))),
            (np.zeros(12), np.zeros(12)),
            (np.zeros((4, 3)), np.zeros((5, 3))),
        ]:
            with self.assertRaises(ValueError):
                estimate_curvature(positions, normals)

    def test_options_that_exclude_each_other_are_refused(self):
        cloud = np.zeros((4, 3)), np.zeros((4, 3))
        for options in [{"estimator": "best"}, {"neighbor_count": 9, "radius": 1.0}, {"priority": "now"}]:
            with self.assertRaises(ValueError):
                estimate_curvature(*cloud, **options)

    def test_scales_that_make_no_sense_are_refused_before_a_call(self):
        cloud = np.zeros((4, 3)), np.zeros((4, 3))
        need, auto = "need neighbor_count", {"estimator": "auto"}
        for word, options in (
            (need, {"neighbor_count_range": (16, 64)}),
            (need, {"max_radius": 1.0}),
            (need, {"scale_per_cloud": True}),
            (need, {**auto, "neighbor_count": 50, "max_radius": 1.0}),
            ("'auto'", {"neighbor_count": "some"}),
            ("radius does not go with", {**auto, "radius": 1.0}),
            ("radius does not go with", {"neighbor_count": "auto", "radius": 1.0}),
            ("neighbor_count_range is 64", {**auto, "neighbor_count_range": 64}),
            ("neighbor_count_range is (64,)", {**auto, "neighbor_count_range": (64,)}),
            ("neighbor_count_range is (-1, 64)", {**auto, "neighbor_count_range": (-1, 64)}),
            ("neighbor_count_range is '16'", {**auto, "neighbor_count_range": "16"}),
            ("neighbor_count_range is (16, 64.5)", {**auto, "neighbor_count_range": (16, 64.5)}),
        ):
            with self.subTest(options), self.assertRaises(ValueError) as refused:
                estimate_curvature(*cloud, server="127.0.0.1:1", max_attempts=1, **options)
            self.assertIn(word, str(refused.exception))

    def test_numbers_that_do_not_fit_are_named(self):
        cloud = np.zeros((4, 3)), np.zeros((4, 3))
        for name, value, limit in (
            ("neighbor_count", -1, "from 0 to 4294967295"),
            ("neighbor_count", 50.5, "whole number"),
            ("neighbor_count", True, "whole number"),
            ("jet_degree", 2**32, "from 0 to 4294967295"),
            ("seed", 2**64, "from 0 to 18446744073709551615"),
            ("radius", "1", "a number"),
            ("average_normal_weight", [1], "a number"),
            ("max_attempts", 0, "1 or more"),
            ("max_attempts", 1.5, "whole number"),
            ("timeout", float("nan"), "seconds"),
            ("timeout", "5", "a number"),
            ("connect_timeout", float("nan"), "seconds"),
        ):
            with self.subTest((name, value)), self.assertRaises(ValueError) as refused:
                estimate_curvature(*cloud, server="127.0.0.1:1", **{name: value})
            self.assertIn(f"{name} is {value!r}; it must be", str(refused.exception))
            self.assertIn(limit, str(refused.exception))
        for options in ({"normal_neighbor_count": -1}, {"normal_radius": "1"}):
            with self.subTest(options), self.assertRaisesRegex(ValueError, "of normals is .*; it must be a"):
                estimate_curvature(cloud[0], server="127.0.0.1:1", **options)

    def test_nobody_listening_is_unavailable(self):
        with self.assertRaises(CurvdError) as caught:
            estimate_curvature(*sphere(10, 1.0), server="127.0.0.1:1", max_attempts=2)
        self.assertEqual(caught.exception.code, grpc.StatusCode.UNAVAILABLE)
