#!/usr/bin/python3
"""Installs the C++ client and builds README's program with it, in empty folders outside the clone.

  cpp_client_trial.py SOURCE_DIR BUILD_DIR CXX      needs CURVD_SERVER, see tests/languages/with_curvd.py

The prefix is moved after the install, so that whatever remembers where it was made fails. The program is built with
find_package and with pkg-config, and a shared library beside it, which needs position-independent archives.
"""

import os
import pathlib
import subprocess
import sys
import tempfile

LISTS = """cmake_minimum_required(VERSION 3.25)
project(trial CXX)
find_package(curvd 0.1 CONFIG REQUIRED)
if(NOT EXISTS ${curvd_PROTO_DIR}/curvature/v1/curvature.proto)
  message(FATAL_ERROR "no contract in ${curvd_PROTO_DIR}")
endif()
add_library(plugin SHARED plugin.cc)
target_link_libraries(plugin PRIVATE curv::client)
target_link_options(plugin PRIVATE LINKER:--no-undefined)
add_executable(trial program.cc)
target_link_libraries(trial PRIVATE curv::client)
"""
PLUGIN = """#include "client/curvature_client.h"
bool CanConnect(const char* server) { return curv::CurvatureClient::Connect(server).ok(); }
"""
HEADERS = {"automatic_scale.h", "connect_options.h", "curvature_client.h", "io/point_status.h", "normal_options.h"}


def run(*command, **options):
    return subprocess.run(list(map(str, command)), check=True, text=True, stdout=subprocess.PIPE, **options).stdout


def install(build_dir, folder):
    """Returns the prefix, moved to another place than that of the install."""
    for component in ("curvd", "curv", "dev"):
        run("cmake", "--install", build_dir, "--prefix", folder / "first", "--component", component)
    return (folder / "first").rename(folder / "prefix")


def check_files(prefix, source_dir):
    """Headers of the client alone; no text file that names the clone."""
    client = prefix / "include" / "curvd" / "client"
    found = {str(path.relative_to(client)) for path in client.rglob("*.h")}
    assert found == HEADERS, f"headers are {sorted(found)}"
    texts = [path for path in prefix.rglob("*") if path.suffix in (".cmake", ".pc", ".h", ".proto")]
    naming = [path.name for path in texts if str(source_dir) in path.read_text(encoding="utf-8")]
    assert len(texts) > 10 and not naming, f"{len(texts)} files, of which {naming} name {source_dir}"


def check_answer(program):
    answer = run(program, os.environ["CURVD_SERVER"])
    mean = float(answer.split()[1].rstrip(","))
    # The sphere's radius is 2; 10,000 exact points are good for four digits.
    assert abs(mean - 0.5) < 1e-3, answer
    print(f"{program.name}: {answer.strip()}")


def main():
    source_dir, build_dir, compiler = sys.argv[1:]
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        prefix = install(build_dir, folder)
        check_files(prefix, source_dir)
        print(run(prefix / "bin" / "curv", "--version") + run(prefix / "bin" / "curvd", "--version"), end="")

        program = folder / "program.cc"
        snippets = f"{source_dir}/tests/docs/snippets.py"
        run("/usr/bin/python3", snippets, "extract", f"{source_dir}/README.md", "cpp", program)
        (folder / "CMakeLists.txt").write_text(LISTS, encoding="utf-8")
        (folder / "plugin.cc").write_text(PLUGIN, encoding="utf-8")
        run("cmake", "-S", folder, "-B", folder / "out",
            f"-DCMAKE_PREFIX_PATH={prefix}", f"-DCMAKE_CXX_COMPILER={compiler}")
        run("cmake", "--build", folder / "out")
        check_answer(folder / "out" / "trial")

        (pkgconfig,) = [path.parent for path in prefix.rglob("curvd-client.pc")]
        flags = run("pkg-config", "--cflags", "--libs", "curvd-client",
                    env={**os.environ, "PKG_CONFIG_PATH": str(pkgconfig)}).split()
        run(compiler, "-std=c++20", program, "-o", folder / "with_pkg_config", *flags)
        check_answer(folder / "with_pkg_config")


if __name__ == "__main__":
    main()
