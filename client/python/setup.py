"""Builds the package from a clone: adds the contract's descriptors and types, which protoc makes. See
pyproject.toml."""

import os
import pathlib
import subprocess

from setuptools import setup
from setuptools.command.build_py import build_py

_HERE = pathlib.Path(__file__).resolve().parent
_PROTO = _HERE.parent.parent / "proto"


class BuildWithContract(build_py):
    """Copies the sources, then generates contract.binpb and curvature_pb2.pyi beside them."""

    def run(self):
        super().run()
        package = pathlib.Path(self.build_lib) / "curvd_client"
        package.mkdir(parents=True, exist_ok=True)
        _protoc(
            f"-I{_PROTO}", "--include_imports", f"--descriptor_set_out={package / 'contract.binpb'}",
            "curvature/v1/curvature.proto", "google/rpc/status.proto", "google/rpc/error_details.proto",
        )
        _protoc(f"-I{_PROTO / 'curvature' / 'v1'}", f"--pyi_out={package}", "curvature.proto")


def _protoc(*arguments):
    program = os.environ.get("PROTOC", "protoc")
    try:
        subprocess.run([program, *arguments], check=True)
    except FileNotFoundError:
        raise SystemExit(f"{program} is not installed; Debian's package is protobuf-compiler") from None


setup(cmdclass={"build_py": BuildWithContract})
