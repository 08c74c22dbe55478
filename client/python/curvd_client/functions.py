"""Functions for programs that keep no client: each call finds the one that was made for its server before."""

from __future__ import annotations

import collections
import os
import pathlib
import threading
import typing

import grpc
import numpy.typing as npt

from curvd_client.addresses import DEFAULT_SERVER, require_server
from curvd_client.cancelling import Cancel
from curvd_client.client import CurvatureClient
from curvd_client.exchange import make_request, warn
from curvd_client.options import CurvatureOptions, NormalsOptions, curvature_header, normals_header
from curvd_client.progress import ProgressCallback
from curvd_client.results import Estimate
from curvd_client.retries import DEFAULT_ATTEMPTS, DEFAULT_CONNECT_SECONDS
from curvd_client.security import Security, require_security

if typing.TYPE_CHECKING:
    from typing_extensions import Unpack

_NO_SECURITY = Security()
_MOST_CLIENTS = 16


def estimate_curvature(
    positions: npt.ArrayLike,
    normals: npt.ArrayLike | None = None,
    *,
    server: str = DEFAULT_SERVER,
    security: Security = _NO_SECURITY,
    channel: grpc.Channel | None = None,
    timeout: float | None = None,
    max_attempts: int = DEFAULT_ATTEMPTS,
    connect_timeout: float = DEFAULT_CONNECT_SECONDS,
    cancel: Cancel | None = None,
    progress: ProgressCallback | bool = False,
    **options: Unpack[CurvatureOptions],
) -> Estimate:
    """Estimates the curvature at every point of a cloud.

    positions, normals:    arrays of shape (N, 3), of any real dtype, byte order and strides. Positions are sent as
                           float32 where that holds each of their values (float32, float16, integers of up to 16 bits),
                           and else as float64, which keeps georeferenced scans exact. Normals point outward, of any
                           length above zero. Without normals (None), the server estimates and orients them, and the
                           result has them as `normal`.
    server:                HOST or HOST:PORT (50061), a gRPC target, or several with commas between: replicas, which
                           calls go to in turn. Connections are kept from call to call.
    estimator:             "avg-hexagram", "hexagram", "uniform", "independent", "delaunay", "jet", "aso",
                           "normal-regression", or "auto": what suits the cloud, averaged; summary.scale tells what was
                           chosen, and why.
    neighbor_count:        the K nearest points, the point itself included; or "auto": as noise and detail ask for, at
                           each point, for "auto" and the estimators that it chooses among. DEFAULT: 50, if there is no
                           radius; with the estimator "auto", "auto".
    neighbor_counts:       instead, several numbers of neighbors in ascending order, at most 16, with one search for the
                           largest, for "avg-hexagram" and "normal-regression": the result has columns for each,
                           mean_curvature_k16, ..., status_k16, with the bytes of a call with that neighbor_count alone.
                           summary.status_counts counts a point once for each.
    radius:                all points at most this far away, instead of neighbor_count.
    neighbor_count_range:  of neighbor_count "auto": the fewest and the most points. DEFAULT: (16, 2048), the widest
                           there is, or up to what the server allows.
    max_radius:            of neighbor_count "auto": how far an estimate looks at most. DEFAULT: any distance.
    scale_per_cloud:       of neighbor_count "auto": the same choice for all points.
    triangle_count, seed:  of the random strategies. DEFAULT: 100 triangles, seed 0.
    rotation_count:        hexagrams that avg-hexagram averages over, 1 to 4. DEFAULT: 2.
    jet_degree:            of the polynomial that jet fits, 2 to 4; 4 for exact positions only. DEFAULT: 2; with
                           neighbor_count "auto" 4, and no other.
    regression_degree:     of the polynomials that normal-regression fits, 1 to 3: 3 follows the surface farther, 2 takes
                           more of the noise away, and 1, fitted over space, is right for spheres, cylinders and planes
                           at any size. DEFAULT: 3.
    even_weights:          count all triangles of delaunay alike, as the paper does.
    project:               estimate, by aso, the surface beside the point, not the level of the fitted field through it:
                           for noisy positions. With neighbor_count "auto" always.
    average_normal_weight: share of the neighborhood's mean normal, in [0, 1]. DEFAULT: 0.5.
    orientation:           which side is out: "consistent" (neighbors agree, closed pieces are seen from outside) or
                           "closed" (the same for closed surfaces with holes). Normals that are given are then turned,
                           as with viewpoint and direction. DEFAULT: given normals stay; estimated ones are consistent.
    viewpoint:             instead: where the surface was seen from, shape (3,), or where each point was, (N, 3).
    direction:             instead: no normal points against it, shape (3,).
    normal_method:         of estimated normals: "pca", "jet-1", "jet-2" or "jet-4". DEFAULT: jet-2 or jet-4, as the
                           points ask for.
    normal_neighbor_count, normal_radius: of which points normals are estimated. DEFAULT: as many as the noise of the
                           points asks for.
    quantities:            names of QUANTITIES that the result shall have, beside `status`. DEFAULT (none, or []): all
                           of curvature that comes without being asked for, DEFAULT_QUANTITIES, and "normals" unless
                           they stay as they are given. [*DEFAULT_QUANTITIES, "standard_errors"] asks for more:
                           "shape_index", "curvedness"; "standard_errors" of mean_curvature, k1 and k2, of the
                           estimators "auto", "avg-hexagram", "normal-regression", "jet" of degree 4, and "aso" with
                           project, with neighbor_count "auto" or from 16 to 2,048; "chosen_neighbor_count" and "estimator_weights" of "auto";
                           "normal_curvature".
    curvature_direction:   of the quantity "normal_curvature": the direction in which it is wanted, shape (3,), or one for
                           each point, (N, 3), of any length; it is projected on the tangent plane. NaN where nothing
                           is left of it.
    skip_invalid:          give an unusable point a status instead of failing the call.
    reject_opposed_normals: fail the call if normals point to opposite sides of one surface, instead of giving the
                           points around such places a status, and warning.
    priority:              "interactive" if somebody waits, "batch" if it can wait. DEFAULT: interactive up to 100,000
                           points, batch above.
    request_tag:           free text for the server's log.
    timeout:               seconds for the whole call with its retries, above 0. DEFAULT: no limit.
    max_attempts:          times the cloud is sent at most, while servers are unavailable or ask to wait: at once to the
                           next replica, then with growing pauses. DEFAULT: 6, over about 8 seconds.
    connect_timeout:       seconds, from 0, after which a call gives up if no server has ever answered and each was tried.
                           DEFAULT: 1.5.
    cancel:                a Cancel, whose method cancel ends the call from another thread.
    progress:              a function that is called with a Progress now and then, in this thread; or True: a line on
                           stderr, if that is a terminal. What it raises ends the call.
    security:              TLS and token, see Security. DEFAULT: plain text, no token.
    channel:               a channel of your own instead of `server`; security's token is not checked for plain text
                           then.

    Returns an Estimate. Raises CurvdError if the call fails, ValueError or TypeError if the arguments make no request.
    What the server finds wrong with a cloud that it estimates nevertheless (summary.warnings) is issued as a
    CurvdWarning. Thread-safe.
    """
    request = make_request(curvature_header(normals is not None, **options), positions, normals)
    client = _client_of(server, security, channel)
    estimate = client._estimate(request, timeout, max_attempts, connect_timeout, cancel, progress)
    warn(estimate, stacklevel=2)
    return estimate


def estimate_normals(
    positions: npt.ArrayLike,
    normals: npt.ArrayLike | None = None,
    *,
    server: str = DEFAULT_SERVER,
    security: Security = _NO_SECURITY,
    channel: grpc.Channel | None = None,
    timeout: float | None = None,
    max_attempts: int = DEFAULT_ATTEMPTS,
    connect_timeout: float = DEFAULT_CONNECT_SECONDS,
    cancel: Cancel | None = None,
    progress: ProgressCallback | bool = False,
    **options: Unpack[NormalsOptions],
) -> Estimate:
    """Estimates the normal at every point of a cloud; or turns those that are given, as orientation, viewpoint or
    direction says.

    method, neighbor_count, radius: as estimate_curvature has them for normals.
    All others:                     as there.

    Returns an Estimate whose points have `normal`, of unit length, `normal_residual`, `normal_variance_ratio` (both NaN
    for normals that were given) and `status`, which says why there is no normal where it is not PointStatus.OK.
    summary.normals tells how they were made, and whether their sides can be trusted. Raises and warns as
    estimate_curvature. Thread-safe.
    """
    request = make_request(normals_header(normals is not None, **options), positions, normals)
    client = _client_of(server, security, channel)
    estimate = client._estimate(request, timeout, max_attempts, connect_timeout, cancel, progress)
    warn(estimate, stacklevel=2)
    return estimate


_clients: collections.OrderedDict[object, CurvatureClient] = collections.OrderedDict()
_clients_lock = threading.Lock()


def _client_of(server: str, security: Security, channel: grpc.Channel | None) -> CurvatureClient:
    """The client that earlier calls used; a new one in a process that was forked, or where files of keys have
    changed."""
    if channel is not None:
        return CurvatureClient(security=security, channel=channel)
    require_security(security)
    require_server(server)
    files = (security.ca_file, security.cert_file, security.key_file)
    key = (os.getpid(), server, security, tuple(_age(file) for file in files))
    with _clients_lock:
        client = _clients.pop(key, None) or CurvatureClient(server, security=security)
        _clients[key] = client
        if len(_clients) > _MOST_CLIENTS:
            # Not closed: a call may still use it, and its connections end with it.
            _clients.popitem(last=False)
    return client


def _age(file: str | os.PathLike[str] | None) -> int | None:
    try:
        return None if file is None else pathlib.Path(file).stat().st_mtime_ns
    except OSError:
        return None  # opening the channel says what is wrong
