"""What tests against a real curvd (CURVD_SERVER) have in common."""

import os
import unittest

import numpy as np

from curvd_client import PointStatus


class RealServerTest(unittest.TestCase):
    def setUp(self):
        self.server = os.environ["CURVD_SERVER"]

    def assert_sphere(self, points, radius):
        # 20,000 points: the error of the estimate itself is far below a percent.
        np.testing.assert_allclose(points["mean_curvature"], 1 / radius, rtol=0.02)
        np.testing.assert_allclose(points["gaussian_curvature"], 1 / radius**2, rtol=0.04)
        self.assertTrue(np.all(points["k1"] <= points["k2"]))
        self.assertTrue(np.all(points["status"] == PointStatus.OK))
