"""Curvature of point clouds, and their normals, from a curvd server: numpy arrays in, a numpy array out.

estimate_curvature and estimate_normals make one call; CurvatureClient keeps its connections and can be asked for more;
curvd_client.aio has the same for asyncio.
"""

from curvd_client._version import __version__
from curvd_client.cancelling import Cancel
from curvd_client.client import CurvatureClient
from curvd_client.errors import CurvdError, CurvdWarning
from curvd_client.functions import estimate_curvature, estimate_normals
from curvd_client.progress import Progress
from curvd_client.results import DEFAULT_QUANTITIES, QUANTITIES, RESULT_DTYPE, Estimate, PointStatus
from curvd_client.rpc import ServerInfo, ServerLimits
from curvd_client.security import Security

__all__ = [
    "Cancel",
    "CurvatureClient",
    "CurvdError",
    "CurvdWarning",
    "DEFAULT_QUANTITIES",
    "Estimate",
    "PointStatus",
    "Progress",
    "QUANTITIES",
    "RESULT_DTYPE",
    "Security",
    "ServerInfo",
    "ServerLimits",
    "__version__",
    "estimate_curvature",
    "estimate_normals",
]
