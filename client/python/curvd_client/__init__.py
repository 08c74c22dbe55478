"""Curvature of point clouds, and their normals, from a curvd server: numpy arrays in, a numpy array out."""

from curvd_client.client import Estimate, estimate_curvature, estimate_normals
from curvd_client.errors import CurvdError, CurvdWarning
from curvd_client.results import QUANTITIES, RESULT_DTYPE, PointStatus
from curvd_client.security import Security

__all__ = [
    "CurvdError",
    "CurvdWarning",
    "Estimate",
    "PointStatus",
    "QUANTITIES",
    "RESULT_DTYPE",
    "Security",
    "estimate_curvature",
    "estimate_normals",
]
