"""The command curvd-client: estimate, info, health. Exit codes are those of curv."""

from __future__ import annotations

import argparse
import json
import math
import os
import pathlib
import re
import sys
import typing
import warnings

import grpc

from curvd_client import _version
from curvd_client.addresses import DEFAULT_SERVER, drawn
from curvd_client.client import CurvatureClient
from curvd_client.errors import CurvdError, CurvdWarning
from curvd_client.files import read_cloud, write_points
from curvd_client.options import ESTIMATORS
from curvd_client.results import QUANTITIES
from curvd_client.security import Security

_LEAST_NEIGHBORS, _MOST_NEIGHBORS = 4, 1_000_000  # as curv; a server may take fewer
# What messages of Security begin with.
_FLAGS = {
    "ca_file": "--tls-ca",
    "cert_file and key_file": "--tls-cert and --tls-key",
    "server_name": "--tls-server-name",
    "token": "--token-file: the token",
}
# What the arguments of a call, and fields of its header, are called here.
_ARGUMENTS = {
    r"^neighbor_counts exclude neighbor_count, radius\b": "several numbers of --k exclude --radius",
    r"; max_radius says .*": "",
    r"header\.options\.estimator\b": "--estimator",
    r"(header\.options\.)?\bneighbor_counts?\b": "--k",
    r"(header\.options\.|^|(?<=and ))radius\b": "--radius",
    r"a curvature_direction\b": "--direction",
    r"^quantity\b": "--quantities:",
}
_REFUSED, _BAD_INPUT, _BAD_OUTPUT, _NO_SERVER, _OUT_OF_TIME, _INTERRUPTED = 1, 3, 4, 5, 6, 130


def main(arguments: typing.Sequence[str] | None = None) -> int:
    """Runs the command; returns its exit code."""
    parser = _parser()
    options = parser.parse_args(arguments)
    warnings.showwarning = _show_warning
    try:
        return int(options.run(options))
    except CurvdError as error:
        is_late = error.code == grpc.StatusCode.DEADLINE_EXCEEDED and error.reason in ("", "DEADLINE_EXCEEDED")
        return _fail(_code_of(error), f"{error.code.name}: {_in_flags(error.message)}{': the call took longer than --timeout allows' if is_late else ''}")
    except (OSError, ValueError) as error:
        return _fail(2, _in_flags(str(error)))
    except KeyboardInterrupt:
        return _fail(_INTERRUPTED, "interrupted")


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="curvd-client", description="Curvature of point clouds from a curvd server.")
    parser.add_argument("--version", action="version", version=f"curvd-client {_version.__version__}")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    server = _server_options()

    estimate = commands.add_parser("estimate", parents=[server], help="estimate the curvature of the cloud in a file")
    estimate.add_argument("input", type=pathlib.Path, metavar="IN",
                          help=".npy, .npz, or text: .xyz .txt .csv .pts .asc")  # fmt: skip
    estimate.add_argument("-o", "--output", type=pathlib.Path, required=True, metavar="OUT.npz",
                          help="positions and every column of the result")  # fmt: skip
    estimate.add_argument("--estimator", choices=ESTIMATORS, default="avg-hexagram", help="default: avg-hexagram")
    estimate.add_argument("--k", type=_counts_or_auto, help="points in a neighborhood, or auto, or several with commas between; default: 50")
    estimate.add_argument("--radius", type=_above_zero, help="of a neighborhood, instead of --k")
    estimate.add_argument("--normals", choices=("given", "orient", "estimate"),
                          help="default: given where the file has them, else estimate")  # fmt: skip
    estimate.add_argument("--quantities", type=lambda text: text.split(","), metavar="NAME,...",
                          help="of " + ", ".join(QUANTITIES))  # fmt: skip
    estimate.add_argument("--direction", type=_vector, metavar="X,Y,Z",
                          help="of the quantity normal_curvature")  # fmt: skip
    estimate.add_argument("--skip-invalid", action="store_true", help="give unusable points a status, do not fail")
    estimate.add_argument("--quiet", action="store_true", help="show no progress")
    estimate.set_defaults(run=_estimate)

    info = commands.add_parser("info", parents=[server], help="print what the server is and accepts, as JSON")
    info.set_defaults(run=_info)
    health = commands.add_parser("health", parents=[server], help="print SERVING, exit with 0; or another state, 5")
    health.set_defaults(run=_health)
    return parser


def _server_options() -> argparse.ArgumentParser:
    server = argparse.ArgumentParser(add_help=False)
    server.add_argument("--server", default=DEFAULT_SERVER, metavar="HOST[:PORT]", help=f"default: {DEFAULT_SERVER}")
    server.add_argument("--timeout", type=_above_zero, metavar="SECONDS", help="for the whole call; default: no limit")
    server.add_argument("--connect-timeout", type=_above_zero, default=1.5, metavar="SECONDS",
                        help="give up where no server ever answered; default: 1.5")  # fmt: skip
    server.add_argument("--tls", action="store_true", help="encrypt, and check the server's certificate")
    server.add_argument("--tls-ca", metavar="FILE", help="authorities that its certificate may be of")
    server.add_argument("--tls-cert", metavar="FILE", help="certificate to show")
    server.add_argument("--tls-key", metavar="FILE", help="its private key")
    server.add_argument("--tls-server-name", metavar="NAME", help="to find in the server's certificate")
    server.add_argument("--token-file", type=pathlib.Path, metavar="FILE", help="bearer token, sent with each call")
    return server


def _client(options: argparse.Namespace) -> CurvatureClient:
    for flag in ("tls_ca", "tls_cert", "tls_key", "token_file"):
        _check_readable(flag, getattr(options, flag))
    token = None
    if options.token_file is not None:
        token = options.token_file.read_bytes().decode("utf-8", "replace").strip()
        if not token:
            raise ValueError(f"--token-file: {options.token_file} holds no token")
    server, name = drawn(options.server)
    security = Security(
        tls=options.tls,
        ca_file=options.tls_ca,
        cert_file=options.tls_cert,
        key_file=options.tls_key,
        server_name=options.tls_server_name or (name if options.tls or options.tls_ca or options.tls_cert else None),
        token=token,
    )
    try:
        return CurvatureClient(server, security=security)
    except ValueError as error:
        start = re.match("|".join(sorted(_FLAGS, key=len, reverse=True)), str(error))
        raise ValueError(str(error) if start is None else _FLAGS[start[0]] + str(error)[start.end() :]) from None


def _check_readable(flag: str, file: str | os.PathLike[str] | None) -> None:
    """Raises ValueError, naming flag and file, if it cannot be read. What is no regular file can be read but once."""
    if file is None or (os.path.exists(file) and not os.path.isfile(file) and not os.path.isdir(file)):
        return
    try:
        open(file, "rb").close()
    except OSError as error:
        raise ValueError(f"--{flag.replace('_', '-')}: {file}: {error.strerror}") from None


def _waits(options: argparse.Namespace) -> dict[str, typing.Any]:
    return {"timeout": options.timeout, "connect_timeout": options.connect_timeout}


def _estimate(options: argparse.Namespace) -> int:
    if options.output.suffix.lower() != ".npz":
        return _fail(2, f"--output is {options.output}; it must end in .npz")
    if os.path.isfile(options.output) and os.path.exists(options.input) and os.path.samefile(options.input, options.output):
        return _fail(2, f"--output: {options.output} would replace the input {options.input}: name another file")
    try:
        positions, normals = read_cloud(options.input)
    except OSError as error:
        return _fail(_BAD_INPUT, f"{options.input}: {error.strerror or error}")
    except ValueError as error:
        return _fail(_BAD_INPUT, f"{options.input}: {error}")
    if not os.access(options.output.parent, os.W_OK):  # before the work, which may take long
        return _fail(_BAD_OUTPUT, f"{options.output}: No such file or directory, or no permission to write there")
    if normals is None and options.normals in ("given", "orient"):
        return _fail(_BAD_INPUT, f"{options.input} has no normals; --normals=estimate makes them")
    with _client(options) as client:
        points, summary = client.estimate(
            positions,
            None if options.normals == "estimate" else normals,
            orientation="consistent" if options.normals == "orient" else None,
            estimator=options.estimator,
            neighbor_count=None if isinstance(options.k, list) else options.k,
            neighbor_counts=options.k if isinstance(options.k, list) else None,
            radius=options.radius,
            quantities=options.quantities,
            curvature_direction=options.direction,
            skip_invalid=options.skip_invalid,
            progress=not options.quiet,
            **_waits(options),
        )
    try:
        write_points(options.output, positions, points)
    except OSError as error:
        return _fail(_BAD_OUTPUT, f"{options.output}: {error.strerror or error}")
    return _say(f"{len(points):,} {'point' if len(points) == 1 else 'points'}, {summary.status_counts.ok:,} estimated{_scales(options.k)}: {options.output}")


def _scales(k: object) -> str:
    return f" at {len(k)} neighbor counts" if isinstance(k, list) else ""


def _info(options: argparse.Namespace) -> int:
    with _client(options) as client:
        info = client.info(**_waits(options))
    return _say(json.dumps({**info._asdict(), "limits": info.limits._asdict()}, indent=2))


def _health(options: argparse.Namespace) -> int:
    with _client(options) as client:
        state = client.health(**_waits(options))
    return _say(state) or (0 if state == "SERVING" else _NO_SERVER)


def _say(text: str) -> int:
    """Writes to standard output; returns the exit code."""
    try:
        print(text, flush=True)
    except OSError as error:
        sys.stdout = open(os.devnull, "w", encoding="utf-8")  # else Python would write the rest once more, at the end
        return _fail(_BAD_OUTPUT, f"standard output: {error.strerror}")
    return 0


def _counts_or_auto(text: str) -> int | str | list[int]:
    if text == "auto":
        return text
    counts = [int(part) if re.fullmatch("[0-9]{1,9}", part) else 0 for part in text.split(",")]
    if not all(_LEAST_NEIGHBORS <= count <= _MOST_NEIGHBORS for count in counts):
        limits = f"whole numbers from {_LEAST_NEIGHBORS} to {_MOST_NEIGHBORS}"
        raise argparse.ArgumentTypeError(f'"{text}" must be auto, or {limits} with commas between')
    return counts if len(counts) > 1 else counts[0]


def _above_zero(text: str) -> float:
    number = _float(text)
    if not 0 < number < math.inf:
        raise argparse.ArgumentTypeError(f'"{text}" must be a finite number above 0')
    return number


def _vector(text: str) -> list[float]:
    parts = [_float(part) for part in text.split(",")]
    if len(parts) != 3 or not all(map(math.isfinite, parts)):
        raise argparse.ArgumentTypeError(f'"{text}" must be three finite numbers with commas between')
    return parts


def _float(text: str) -> float:
    """NaN for what is no number."""
    try:
        return float(text)
    except ValueError:
        return math.nan


def _in_flags(message: str) -> str:
    for argument, flag in _ARGUMENTS.items():
        message = re.sub(argument, flag, message)
    return message


def _code_of(error: CurvdError) -> int:
    if error.code == grpc.StatusCode.UNAVAILABLE:
        return _NO_SERVER
    return _OUT_OF_TIME if error.code == grpc.StatusCode.DEADLINE_EXCEEDED else _REFUSED


def _fail(code: int, message: str) -> int:
    print(f"curvd-client: {message}", file=sys.stderr)
    return code


def _show_warning(message: Warning | str, category: type[Warning], *where: object, **more: object) -> None:
    prefix = "warning" if issubclass(category, CurvdWarning) or category is UserWarning else category.__name__
    print(f"curvd-client: {prefix}: {message}", file=sys.stderr)


if __name__ == "__main__":
    sys.exit(main())
