#!/usr/bin/python3
"""Writes the seeds of the fuzz targets: make_corpus.py PROTO_DIR CORPUS_DIR

Small inputs that reach every branch a well-formed one can reach; the fuzzers make the malformed ones themselves. Inputs
that were findings once lie beside the seeds as regression-*, and are not touched.
"""

import hashlib
import importlib
import io
import pathlib
import struct
import subprocess
import sys
import tempfile

import numpy as np


def readers():
    """Seeds of the file readers, by target and name."""
    floats = struct.pack("<6f", 1, 2, 3, 0, 0, 1) + struct.pack("<6f", 4, 5, 6, 0, 1, 0)
    swapped = struct.pack(">6f", 1, 2, 3, 0, 0, 1) + struct.pack(">6f", 4, 5, 6, 0, 1, 0)
    rows = b"1 2 3 0 0 1\n4 5 6 0 1 0\n"

    names = ("x", "y", "z", "nx", "ny", "nz")

    def ply(form, properties=None, count=2, tail=b""):
        lines = properties or [f"property float {name}" for name in names]
        head = ["ply", f"format {form} 1.0", "comment seed", f"element vertex {count}", *lines]
        return "\n".join(head).encode() + b"\n" + tail + b"end_header\n"

    faces = b"element face 1\nproperty list uchar int vertex_indices\n"
    kinds = ["char a", "uchar b", "short c", "ushort d", "int e", "uint f", "float g", "double h"]
    yield "ply", "ascii", ply("ascii") + rows
    yield "ply", "little", ply("binary_little_endian") + floats
    yield "ply", "big", ply("binary_big_endian") + swapped
    yield "ply", "faces", ply("ascii", tail=faces) + rows + b"3 0 1 1\n"
    yield "ply", "types", ply("binary_little_endian", [f"property {kind}" for kind in kinds], 1) + bytes(26)
    yield "ply", "vertex_list", (
        ply("binary_little_endian", ["property list uchar short ring", "property float x"], 1)
        + struct.pack("<B2hf", 2, 7, 8, 1.5))
    yield "ply", "vertex_list_ascii", ply("ascii", ["property list uchar short ring", "property float x"], 1) + b"2 7 8 1.5\n"
    yield "ply", "element_first", (
        b"ply\nformat binary_little_endian 1.0\nelement camera 1\nproperty list uint char path\nproperty short id\n"
        b"element vertex 1\nproperty int8 x\nend_header\n" + struct.pack("<I2bhb", 2, 1, 2, 3, 4))
    yield "ply", "hostile_count", ply("binary_little_endian", count=1 << 60) + floats

    def pcd(data, fields="x y z normal_x normal_y normal_z", sizes="4 4 4 4 4 4", types="F F F F F F",
            counts="1 1 1 1 1 1", points=2):
        return (f"# .PCD v0.7\nVERSION 0.7\nFIELDS {fields}\nSIZE {sizes}\nTYPE {types}\nCOUNT {counts}\n"
                f"WIDTH {points}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {points}\nDATA {data}\n").encode()

    columns = b"".join(floats[4 * field:4 * field + 4] + floats[24 + 4 * field:28 + 4 * field] for field in range(6))
    # LZF: literal runs of up to 32 bytes behind their length less one.
    literals = b"".join(bytes([len(run) - 1]) + run for run in (columns[:32], columns[32:]))
    # A zero, then a back reference of 8 more.
    zeros = b"\x00\x00" + bytes([6 << 5, 0])
    yield "pcd", "ascii", pcd("ascii") + rows
    yield "pcd", "binary", pcd("binary") + floats
    yield "pcd", "compressed", pcd("binary_compressed") + struct.pack("<2I", len(literals), len(columns)) + literals
    yield "pcd", "references", (
        pcd("binary_compressed", "t _", "8 1", "I U", "1 1", 1) + struct.pack("<2I", len(zeros), 9) + zeros)
    yield "pcd", "vectors", pcd("binary", "x _ fpfh u", "4 1 4 8", "F U F U", "1 4 2 1", 1) + bytes(24)
    yield "pcd", "small_types", pcd("binary", "a b c d e f", "1 1 2 2 4 4", "I U I U I U", points=1) + bytes(14)
    yield "pcd", "hostile_count", pcd("binary", points=1 << 60) + floats
    yield "pcd", "hostile_lzf", pcd("binary_compressed", points=1 << 24) + struct.pack("<2I", 4, 24 << 24) + b"\x00\x00\xe0\xff"

    yield "obj", "normals", b"# seed\nv 1 2 3\nv 4 5 6\nvn 0 0 1\nvn 0 1 0\n"
    yield "obj", "faces", b"v 1 2 3\nv 4 5 6\nv 7 8 9\nvn 0 0 1\nf 1//1 2//1 3//1\nf -1//-1 -2//-1 -3//-1\n"
    yield "obj", "texture", b"mtllib a.mtl\nv 1 2 3 0.5\nvt 0 1\nvn 0 0 1\ng all\nf 1/1/1\np 1\nl 1 1\n"

    yield "xyz", "six", rows
    yield "xyz", "counted", b"2\n" + rows
    yield "xyz", "commas", b"// x;y;z\n1, 2; 3\n# end\n4,5,6\n"
    yield "xyz", "colors", b"1 2 3 255 128 0\n4 5 6 0 0 7\n"
    yield "xyz", "wide", b"1 2 3 0 0 1 7 8e-300 inf\n4 5 6 0 1 0 nan -0 1e-400\n"

    yield "csv", "oriented", b"x,y,z,nx,ny,nz\n1,2,3,0,0,1\n4,5,6,0,1,0\n"
    yield "csv", "results", b"x,mean,status\n1, 0.5 ,ok\n\n2,nan,too_few_neighbors\r\n3,nan,singular_fit\n"


def las():
    """Seeds of the LAS reader, by the layout of the ASPRS LAS 1.4 R15 specification."""
    core = struct.pack("<3iH", 1, -2, 3, 40000)
    legacy = core + bytes([2 | 3 << 3, 2 | 1 << 6]) + struct.pack("<bBH", -9, 7, 600)
    modern = core + bytes([2 | 3 << 4, 1 << 1, 2, 7]) + struct.pack("<hH", -9, 600)
    time, colors, infrared = struct.pack("<d", 1e8), struct.pack("<3H", 1, 2, 3), struct.pack("<H", 4)
    wave = struct.pack("<BQI4f", 1, 60, 64, 0.5, 1, 0, 0)
    points = (legacy, legacy + time, legacy + colors, legacy + time + colors, legacy + time + wave,
              legacy + time + colors + wave, modern + time, modern + time + colors, modern + time + colors + infrared,
              modern + time + wave, modern + time + colors + infrared + wave)

    def record(user, number, payload, extended=False):
        return struct.pack("<H16sH" + ("Q" if extended else "H") + "32s", 0, user, number, len(payload), b"") + payload

    def descriptor(kind, name, options=0, scale=0):
        return struct.pack("<2xBB32s4x72xd16x24x32s", kind, options, name, scale, b"seed")

    def file(form, minor, records=(), extended=(), extra=b"", count=2):
        head_bytes = {2: 227, 3: 235, 4: 375}[minor]
        before, body, after = b"".join(records), 2 * (points[form] + extra), b"".join(extended)
        at = head_bytes + len(before)
        legacy_count = count if minor < 4 else 0
        head = struct.pack("<4sHH16sBB32s32sHHHIIBHI5I12d", b"LASF", 0, 2 if minor == 3 else 16, b"", 1, minor, b"", b"",
                           1, 2020, head_bytes, at, len(records), form, len(body) // 2, legacy_count, 0, legacy_count, 0, 0, 0,
                           0.01, 0.01, 0.01, 5e5, 4.5e6, 0, *6 * [0])
        if minor >= 3:
            head += struct.pack("<Q", at + len(body) if after else 0)
        if minor == 4:
            head += struct.pack("<QIQ15Q", at + len(body) if after else 0, len(extended), count, *15 * [0])
        return head + before + body + after

    normals = b"".join(descriptor(9, b"normal_" + axis) for axis in (b"x", b"y", b"z"))
    for form in range(11):
        yield "las", f"format_{form}", file(form, 2 if form < 4 else 3 if form < 6 else 4)
    yield "las", "normals", file(6, 4, [record(b"LASF_Spec", 4, normals)], extra=struct.pack("<3f", 0, 0, 1))
    kinds = b"".join(descriptor(kind, b"extra") for kind in range(1, 11)) + descriptor(29, b"triple") + descriptor(0, b"", 3)
    yield "las", "extra_types", file(0, 2, [record(b"LASF_Spec", 4, kinds)], extra=b"\xff" * (42 + 12 + 3))
    yield "las", "scaled", file(1, 2, [record(b"LASF_Spec", 4, descriptor(3, b"width", 9, 0.5))], extra=b"\0\0")
    yield "las", "mismatch", file(1, 2, [record(b"LASF_Spec", 4, descriptor(10, b"width"))], extra=b"\0\0")
    keys = struct.pack("<8H", 1, 1, 0, 1, 1024, 0, 1, 2)
    yield "las", "records", file(7, 4, [record(b"LASF_Projection", 34735, keys), record(b"LASF_Projection", 2112, b"GEOGCS[]")],
                                 [record(b"seed", 1, b"abc", True)])
    yield "las", "waveforms", file(4, 3, extended=[record(b"LASF_Spec", 65535, bytes(64), True)])
    yield "las", "hostile_count", file(6, 4, count=1 << 60)
    yield "las", "compressed", file(0, 2)[:104] + b"\x80" + file(0, 2)[105:]


def numpy_files():
    """Seeds of the readers of numpy's files; numpy writes them."""
    def saved(save, *arrays, **named):
        stream = io.BytesIO()
        save(stream, *arrays, **named)
        return stream.getvalue()

    cloud = np.arange(12, dtype="<f8").reshape(2, 6)
    yield "npy", "six", saved(np.save, cloud)
    yield "npy", "fortran", saved(np.save, np.asfortranarray(cloud[:, :3]))
    yield "npy", "big", saved(np.save, cloud.astype(">f4"))
    yield "npy", "wide_integers", saved(np.save, cloud.astype("<i8") << 60)
    fields = np.zeros(2, dtype=[("x", "<f4"), ("y", ">f8"), ("z", "|i1"), ("normal", "<f4", (3,)), ("name", "<U2"), ("ok", "?")])
    yield "npy", "fields", saved(np.save, fields)
    yield "npy", "padding", saved(np.save, np.zeros(1, dtype=np.dtype([("x", "<f8"), ("c", "|u1")], align=True)))
    yield "npy", "hostile_shape", saved(np.save, cloud).replace(b"(2, 6), }       ", b"(99999999, 6), }")
    yield "npz", "stored", saved(np.savez, positions=cloud[:, :3], normals=cloud[:, 3:], k1=cloud[:, 0], other=np.zeros(7))
    yield "npz", "deflated", saved(np.savez_compressed, x=cloud[:, 0], y=cloud[:, 1], z=cloud[:, 2], fields=fields)


def access():
    """Seeds of the readers of tokens and names."""
    digest = hashlib.sha256(b"alice sha256:").hexdigest()
    yield "access", "tokens", f"# who\nalice sha256:{digest} max-streams=4 max-points=5000000\n\nbob sha256:{digest}\n".encode()
    yield "access", "names", b"scanner-7.example.com\nspiffe://example.com/lab  max-streams=4\tmax-points=1000000\r\n"
    yield "access", "limits", b"a max-streams=4294967296 max-points=-1\nb max-streams=\n"


def block(message):
    data = message.SerializeToString()
    return struct.pack("<H", len(data)) + data


def answers():
    """Events of the answering side: 0 accept, 1 progress, 2 N complete, 3 write, 4 written, 5 cancel, 6 hold, 7 release, 8 read."""
    yield "answers", "whole", bytes([8, 0, 3, 4, 1, 3, 4, 8, 2, 20, 3, 4, 1, 4, 4, 4, 4])
    yield "answers", "no_points", bytes([0, 2, 0, 3, 4, 4])
    yield "answers", "cancelled", bytes([8, 0, 3, 6, 5, 4, 7, 3, 8])
    yield "answers", "stalled", bytes([8, 0, 3, 35, 35, 5, 35, 4])


def protocol(proto):
    """Seeds of the protocol's targets; tests/fuzz/*_fuzzer.cc tell how their inputs are read."""
    header = proto.CloudHeader(
        point_count=3, scalar_type=1, origin=proto.Vector3(x=1e6, y=-2, z=3), quantities=[1, 3], invalid_point_policy=2,
        request_tag="seed", options=proto.EstimatorOptions(estimator=1, neighbor_count=20, triangle_count=50, seed=7,
                                                           average_normal_weight=0.25, rotation_count=3, jet_degree=4))
    radius = proto.CloudHeader(options=proto.EstimatorOptions(estimator=6, radius=0.5, even_weights=True))
    spheres = proto.CloudHeader(options=proto.EstimatorOptions(estimator=7, project=True))
    yield "header", "spheres", spheres.SerializeToString()
    yield "header", "neighbors", header.SerializeToString()
    yield "header", "radius", radius.SerializeToString()
    scale = proto.AutomaticScale(least_neighbor_count=32, most_neighbor_count=512, max_radius=0.5, per_cloud=True)
    yield "header", "auto", proto.CloudHeader(options=proto.EstimatorOptions(estimator=9)).SerializeToString()
    for name, estimator in (("scale", 9), ("scale_of_jets", 6), ("scale_of_none", 7)):
        options = proto.EstimatorOptions(estimator=estimator, automatic_scale=scale)
        yield "header", name, proto.CloudHeader(options=options).SerializeToString()
    yield "header", "defaults", proto.CloudHeader(point_count=1 << 24, scalar_type=2, priority=2).SerializeToString()

    estimate = proto.NormalOptions(source=3, method=1, neighbor_count=12, orientation=3, viewpoint=proto.Vector3(x=1, y=-2, z=3))
    orient = proto.NormalOptions(source=2, orientation=5, direction=proto.Vector3(z=1))
    seen = proto.NormalOptions(source=3, method=4, radius=0.5, orientation=4)
    for name, options in (("estimate", estimate), ("orient", orient), ("seen", seen)):
        yield "header", name, proto.CloudHeader(normals=options, quantities=[1, 6, 7]).SerializeToString()

    positions = struct.pack("<9f", 1, 2, 3, 4, 5, 6, 7, 8, 9)
    normals = struct.pack("<9f", 0, 0, 1, 0, 2, 0, 0, 0, 0)
    chunk = proto.EstimateCurvatureRequest(chunk=proto.PointChunk(positions=positions, normals=normals))
    raw_header = proto.EstimateCurvatureRequest(header=header)
    yield "session", "raw", b"\0" + block(raw_header) + b"\0" + block(chunk) + b"\3"
    yield "session", "chunks", (b"\1" + block(header) + b"\2\1" + positions[:12] + normals[:12]
                                + b"\2\2" + positions[12:] + normals[12:] + b"\3")
    doubles = struct.pack("<6d", 1e300, 5e6, -1e-300, 0, 0, 1)
    yield "session", "doubles", b"\1" + block(proto.CloudHeader(scalar_type=2)) + b"\2\1" + doubles + b"\3"
    yield "session", "malformed", b"\1" + block(header) + b"\0" + struct.pack("<H", 3) + b"\x12\xff\x01" + b"\3"
    yield "session", "marked", (b"\1" + block(proto.CloudHeader(marks_last_chunk=True)) + b"\2\1" + positions[:12] + normals[:12]
                                + b"\2\x80\3")
    yield "session", "cut_off", b"\1" + block(proto.CloudHeader(marks_last_chunk=True)) + b"\2\1" + positions[:12] + normals[:12]
    yield "session", "bare", b"\1" + block(proto.CloudHeader(normals=estimate)) + b"\2\3" + positions + b"\3"
    yield "session", "normals_unasked", b"\1" + block(proto.CloudHeader(normals=estimate)) + b"\2\x41" + positions[:12] + normals[:12] + b"\3"
    nowhere = struct.pack("<6f", 1, 2, 3, 4, float("nan"), 6)
    for name, policy in (("seen", 1), ("seen_skipping", 2)):
        yield "session", name, (b"\1" + block(proto.CloudHeader(normals=seen, invalid_point_policy=policy))
                                + b"\2\2" + positions[:24] + nowhere + b"\3")
    yield "session", "empty", b"\1" + block(proto.CloudHeader()) + b"\3"

    accepted = proto.EstimateCurvatureResponse(accepted=proto.Accepted(
        request_id="seed-1", limits=proto.ServerLimits(max_points=9, max_chunk_bytes=4096, memory_bytes=1 << 30)))
    progress = proto.EstimateCurvatureResponse(progress=proto.Progress(phase=4, points_received=2, points_estimated=1))
    summary = proto.EstimateCurvatureResponse(summary=proto.Summary(
        point_count=2, status_counts=proto.StatusCounts(ok=2), seconds=proto.PhaseSeconds(send=0.5), peak_bytes=7))
    outcome = proto.ScaleOutcome(estimator=6, degree=4, neighbor_count=64, error=0.4, noise=0.3, bias=0.2, share=1)
    chosen = proto.EstimateCurvatureResponse(summary=proto.Summary(
        point_count=2, status_counts=proto.StatusCounts(ok=2),
        scale=proto.ScaleReport(outcomes=[outcome, outcome], sampled_point_count=512, position_noise=0.01)))
    scalars, vectors = bytes(8), bytes(24)
    result = proto.EstimateCurvatureResponse(result=proto.ResultChunk(
        point_count=2, status=b"\1\1", mean_curvature=scalars, gaussian_curvature=scalars, k1=scalars, k2=scalars,
        d1=vectors, d2=vectors, radius=scalars))
    opening = b"\2\0" + block(accepted) + b"\0" + block(progress)
    yield "response", "raw", opening + b"\0" + block(result) + b"\0" + block(summary)
    yield "response", "scale", opening + b"\0" + block(result) + b"\0" + block(chosen)
    yield "response", "chunk", opening + b"\1\2\1\1" + 5 * scalars + 2 * vectors + b"\0" + block(summary)
    # google.rpc.Status{details: [Any{ErrorInfo}, Any{RetryInfo}]}, written out.
    def field(number, data):
        return bytes([number << 3 | 2, len(data)]) + data

    info = field(1, b"QUEUE_FULL") + field(2, b"curvd") + field(3, field(1, b"limit") + field(2, b"500"))
    retry = field(1, b"\x08\x02\x10\x05")
    details = b"\x08\x08" + b"".join(
        field(3, field(1, b"type.googleapis.com/google.rpc." + name) + field(2, data))
        for name, data in ((b"ErrorInfo", info), (b"RetryInfo", retry)))
    yield "response", "error", b"\2\2\x08" + struct.pack("<H", 5) + b"no, 7" + details


def main():
    proto_dir, corpus_dir = map(pathlib.Path, sys.argv[1:])
    with tempfile.TemporaryDirectory() as generated:
        subprocess.run(["protoc", f"-I{proto_dir}", f"--python_out={generated}", "curvature/v1/curvature.proto"], check=True)
        sys.path.insert(0, generated)
        proto = importlib.import_module("curvature.v1.curvature_pb2")
    seeds = [*readers(), *las(), *numpy_files(), *access(), *answers(), *protocol(proto)]
    for target, name, data in seeds:
        (corpus_dir / target).mkdir(parents=True, exist_ok=True)
        (corpus_dir / target / name).write_bytes(data)
    print(f"{len(seeds)} seeds in {corpus_dir}")


if __name__ == "__main__":
    main()
