#!/usr/bin/python3
"""Makes stubs and runs the program of docs/languages.md, as somebody does who reads it.

  foreign_trial.py go|java SOURCE_DIR CACHE_DIR     needs CURVD_SERVER, see with_curvd.py
  foreign_trial.py names SOURCE_DIR CACHE_DIR       holds the programs that nothing here compiles to the contract

Exits with 77, saying what is missing, where Debian's packages for the language are not installed.
"""

import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

SKIPPED = 77
GO_LIBRARIES = pathlib.Path("/usr/share/gocode/src/google.golang.org")
# The 1.3 that may stand in its place cannot send what protoc-gen-go writes.
GO_PROTOBUF = pathlib.Path("/usr/share/doc/golang-github-golang-protobuf-1-5-dev/copyright")
JAVA_LIBRARIES = pathlib.Path("/usr/share/java")
JARS = ("grpc-api grpc-context grpc-core grpc-netty grpc-protobuf grpc-protobuf-lite grpc-stub protobuf guava "
        "perfmark-api jsr305 opencensus-api geronimo-annotation-1.3-spec jctools-core").split()
# What the programs name, in the contract's words.
USED_FIELDS = {
    "EstimateCurvatureRequest": ["header", "chunk"],
    "EstimateCurvatureResponse": ["result", "summary"],
    "CloudHeader": ["point_count", "scalar_type", "options", "quantities"],
    "EstimatorOptions": ["neighbor_count"],
    "PointChunk": ["positions", "normals"],
    "ResultChunk": ["first_index", "mean_curvature", "status"],
    "Summary": ["point_count"],
}
USED_VALUES = {"ScalarType": "SCALAR_TYPE_FLOAT32", "Quantity": "QUANTITY_MEAN_CURVATURE"}


def missing(wanted, packages):
    """Ends as skipped if one of the files or programs is not there."""
    for each in wanted:
        if not (shutil.which(each) or pathlib.Path(each).exists()):
            print(f"skipped: no {each} (apt install {packages})")
            sys.exit(SKIPPED)


def blocks(source_dir, kind):
    text = (source_dir / "docs" / "languages.md").read_text(encoding="utf-8")
    return re.findall(rf"^```{kind}\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)


def run(command, folder, **environment):
    done = subprocess.run(command, cwd=folder, check=False, text=True, stdout=subprocess.PIPE, env={**os.environ, **environment})
    assert done.returncode == 0, f"{command} ended with {done.returncode}\n{done.stdout}"
    return done.stdout


def check_answer(answer):
    # The sphere's radius is 2; 10,000 exact points are good for four digits.
    assert re.fullmatch(r"mean (0\.500\d|0\.499\d), status 1\n10000 of 10000 points\n", answer), answer
    print(answer, end="")


def make_stubs(source_dir, folder, language, path=None):
    (folder / "proto").symlink_to(source_dir / "proto")
    (folder / "src").mkdir()
    for commands in blocks(source_dir, f"sh {language}"):
        run(["bash", "-euc", commands], folder, PATH=f"{path or ''}:{os.environ['PATH']}")


def build_go(source_dir, cache, folder, main):
    """Makes stubs and a program of the text `main`; returns the words of the command that runs it."""
    packages = "golang-go golang-google-grpc-dev golang-github-golang-protobuf-1-5-dev protobuf-compiler protoc-gen-go protoc-gen-go-grpc"
    missing(["go", "protoc", "protoc-gen-go", "protoc-gen-go-grpc", GO_LIBRARIES / "grpc/server.go", GO_PROTOBUF], packages)
    make_stubs(source_dir, folder, "go")
    (folder / "main.go").write_text(main, encoding="utf-8")
    run(["go", "build", "-o", "program", "main.go"], folder, GO111MODULE="off", GOPATH=f"{folder}:/usr/share/gocode",
        GOCACHE=str(cache / "go"), GOFLAGS="-p=2")
    return [str(folder / "program")]


def build_java(source_dir, folder, name, main):
    """The same for a class of that name."""
    packages = ("default-jdk-headless libgrpc-java libprotobuf-java libnetty-java libperfmark-java libgeronimo-annotation-1.3-spec-java "
                "protobuf-compiler protobuf-compiler-grpc-java-plugin")
    missing(["javac", "protoc", "grpc_java_plugin", *(JAVA_LIBRARIES / f"{jar}.jar" for jar in ("grpc-netty", "netty-codec-http2", "perfmark-api", "geronimo-annotation-1.3-spec"))], packages)
    # protoc looks for another name than Debian gives it.
    (folder / "bin").mkdir()
    (folder / "bin" / "protoc-gen-grpc-java").symlink_to(shutil.which("grpc_java_plugin"))
    make_stubs(source_dir, folder, "java", folder / "bin")
    (folder / f"{name}.java").write_text(main, encoding="utf-8")
    jars = ":".join(str(jar) for jar in sorted(JAVA_LIBRARIES.glob("*.jar")) if jar.stem in JARS or jar.stem.startswith("netty"))
    sources = [str(path) for path in (folder / "src").rglob("*.java")]
    run(["javac", "-nowarn", "-cp", jars, "-d", "classes", *sources, f"{name}.java"], folder)
    return ["java", "-cp", f"{folder / 'classes'}:{jars}", name]


def try_go(source_dir, cache, folder):
    program = build_go(source_dir, cache, folder, blocks(source_dir, "go")[0])
    check_answer(run([*program, os.environ["CURVD_SERVER"]], folder))


def try_java(source_dir, _, folder):
    program = build_java(source_dir, folder, "Sphere", blocks(source_dir, "java")[0])
    check_answer(run([*program, os.environ["CURVD_SERVER"]], folder))


def in_csharp(name):
    return "".join(word.capitalize() for word in name.lower().split("_"))


def try_names(source_dir, *_):
    contract = (source_dir / "proto/curvature/v1/curvature.proto").read_text(encoding="utf-8")
    rust = next(block for block in blocks(source_dir, "text") if "tonic::include_proto" in block)
    csharp = next(block for block in blocks(source_dir, "text") if "Grpc.Net.Client" in block)
    checked = 0

    def both(in_rust, in_csharp_text):
        nonlocal checked
        checked += 1
        for code, word in ((rust, in_rust), (csharp, in_csharp_text)):
            assert re.search(rf"\b{re.escape(word)}\b", code), f"no {word} in\n{code}"

    for message, fields in USED_FIELDS.items():
        body = re.search(rf"^message {message} \{{\n(.*?)^\}}", contract, re.MULTILINE | re.DOTALL)[1]
        for field in fields:
            assert re.search(rf"\b{field} = \d+", body), f"the contract has no {message}.{field}"
            is_choice = message.startswith("EstimateCurvature") or field == "neighbor_count"
            both(in_csharp(field) if is_choice else field, in_csharp(field))
    for enum, value in USED_VALUES.items():
        assert re.search(rf"\b{value} = \d+", contract), f"the contract has no {value}"
        short = in_csharp(value[len(re.sub(r"(?<!^)(?=[A-Z])", "_", enum)) + 1:])
        both(f"{enum}::{short}", f"{enum}.{short}")
    print(f"{checked} names are the contract's")


def main():
    language, source_dir, cache = sys.argv[1], pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3])
    with tempfile.TemporaryDirectory() as folder:
        {"go": try_go, "java": try_java, "names": try_names}[language](source_dir, cache, pathlib.Path(folder))


if __name__ == "__main__":
    main()
