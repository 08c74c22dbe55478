#!/usr/bin/python3
"""Holds the sources to docs/architecture.md: who may include whom, that nobody uses absl::Mutex, and how many files a folder may hold.

  house_test.py SOURCE_FOLDER
"""

import pathlib
import re
import sys

MOST_FILES = 30
# Each of these may include itself and what stands before it.
CORE_ROOMS = ["core/base", "core/cloud", "core/index", "core/search", "core/estimators", "core/normals", "core/scale", "core/job"]
# What the files below a folder may include of the others.
MAY_INCLUDE = {
    "core": {"core"},
    "proto": {"proto", "curvature", "google"},
    "server": {"server", "core", "proto", "curvature", "google"},
    "about": {"about"},
    "client": {"client", "proto", "curvature", "google"},
}
# `curv estimate` without a server runs one inside itself.
EXCEPTIONS = {("client/cli/connection.cc", "server/curvature_server.h")}
# Who knows of which commit it was built is compiled after each: the two programs' own files alone.
EXCEPTIONS |= {(f"{room}/main.cc", "about/version_line.h") for room in ("client", "server")}
# absl::Mutex and what is made of it: Debian's library of them is invisible to the thread sanitizer, which then sees races
# where there are none.
UNSEEN_LOCKS = "absl/synchronization/"
FOREIGN_TO_CORE = ("grpc", "google/protobuf", "prometheus", "curvature/", "spdlog")


def includes(path):
    return re.findall(r'^#include +(["<][^">]+)', path.read_text(encoding="utf-8"), re.MULTILINE)


def core_room(path):
    return next((i for i, room in enumerate(CORE_ROOMS) if path.startswith(room + "/")), None)


def faults_of(path, name, rooms):
    own_room = core_room(path)
    for quoted in includes(name):
        included = quoted[1:]
        top = included.split("/")[0]
        if path.startswith("core/") and included.startswith(FOREIGN_TO_CORE):
            yield f"{path} includes {included}: core knows no gRPC, protobuf, metric or log"
        if quoted[0] == "<" or top not in rooms or (path, included) in EXCEPTIONS:
            continue
        if top not in MAY_INCLUDE[path.split("/")[0]]:
            yield f"{path} includes {included}: an arrow that docs/architecture.md does not have"
        room = core_room(included)
        if own_room is not None and room is not None and room > own_room:
            yield f"{path} includes {included}: {CORE_ROOMS[room]} comes after {CORE_ROOMS[own_room]}"


def unseen_locks(path, name):
    for quoted in includes(name):
        if quoted[1:].startswith(UNSEEN_LOCKS):
            yield f"{path} includes {quoted[1:]}, which the thread sanitizer does not see: take core/base/mutex.h, or std::mutex"


def main():
    root = pathlib.Path(sys.argv[1])
    rooms = set(MAY_INCLUDE) | {"curvature", "google"}
    faults, sizes, checked = [], {}, 0
    for top in [*MAY_INCLUDE, "tests", "bench"]:
        for name in sorted((root / top).rglob("*")):
            if name.suffix not in (".h", ".cc"):
                continue
            path = name.relative_to(root).as_posix()
            checked += 1
            folder = path.rsplit("/", 1)[0]
            sizes[folder] = sizes.get(folder, 0) + 1
            faults += unseen_locks(path, name)
            if top in MAY_INCLUDE:
                faults += faults_of(path, name, rooms)
    faults += [f"{folder} has {size} C++ files; at most {MOST_FILES}" for folder, size in sizes.items() if size > MOST_FILES]
    for fault in faults:
        print(fault)
    print(f"{checked} files looked at, {len(faults)} faults")
    return 1 if faults or checked < 100 else 0


if __name__ == "__main__":
    sys.exit(main())
