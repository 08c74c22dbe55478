#!/usr/bin/python3
"""Builds the Debian packages of a build, looks into them, installs them, and goes through README with what was installed.

  debian_trial.py SOURCE_DIR BUILD_DIR

As root dpkg installs them into this machine's system as it is, under an overlay in memory that goes away with the test, and
removes them again; curvd then runs as the user that its package made, in a network of its own. Who is not root can only
unpack them: dpkg changes owners.
"""

import os
import pathlib
import re
import stat
import subprocess
import sys
import tempfile

import debian_machine

SHIPPED = {
    "curvd": ["usr/bin/curvd", "etc/default/curvd", "etc/curvd/", "lib/systemd/system/curvd.service",
              "usr/share/doc/curvd/operations.md", "usr/share/man/man8/curvd.8.gz", "usr/share/doc/curvd/copyright"],
    "curv": ["usr/bin/curv", "usr/share/doc/curv/copyright", "usr/share/man/man1/curv.1.gz", "usr/share/bash-completion/completions/curv",
             "usr/share/zsh/vendor-completions/_curv", "usr/share/fish/vendor_completions.d/curv.fish"],
    "libcurvd-client-dev": ["usr/include/curvd/client/curvature_client.h", "usr/lib/libcurv_client.a",
                            "usr/lib/pkgconfig/curvd-client.pc", "usr/share/curvd/proto/curvature/v1/curvature.proto"],
}
# What `systemd-analyze security` may say at most: 0 is as closed as can be, 10 is open.
MOST_EXPOSURE = 1.5


def run(*command, **options):
    """Returns what the command printed. Fails with it if the command does."""
    done = subprocess.run(list(map(str, command)), check=False, text=True, stdout=subprocess.PIPE, **options)
    assert done.returncode == 0, f"{' '.join(map(str, command))} ended with {done.returncode}\n{done.stdout}"
    return done.stdout


def build(source_dir, build_dir, folder):
    """Returns the paths of the packages by name."""
    quickly = {**os.environ, "DPKG_DEB_COMPRESSOR_LEVEL": "1"}
    run(f"{source_dir}/deploy/debian/build.sh", build_dir, folder, env=quickly)
    return {path.name.split("_")[0]: path for path in folder.glob("*.deb")}


def check_contents(packages, source_dir):
    assert set(packages) == set(SHIPPED), f"built {sorted(packages)}"
    for name, wanted in SHIPPED.items():
        listed = re.findall(r" \./(\S*)(?: ->.*)?$", run("dpkg-deb", "--contents", packages[name]), re.MULTILINE)
        missing = [path for path in wanted if path not in listed]
        assert not missing, f"{name} lacks {missing}"
    depends = run("dpkg-deb", "--field", packages["curvd"], "Depends")
    assert "libgrpc++1.51" in depends and "libc6 (>=" in depends, depends
    # This machine has all of them, so that no build here would miss one.
    manual = (source_dir / "docs/cpp.md").read_text(encoding="utf-8")
    needed = re.search(r"A program that uses it needs Debian's (.*?), whose programs", manual, re.DOTALL)[1]
    depends = run("dpkg-deb", "--field", packages["libcurvd-client-dev"], "Depends").strip().split(", ")
    assert sorted(re.findall(r"`(\S+)`", needed)) == sorted(depends), (needed, depends)
    version = re.search(r"^project\(curvd VERSION (\S+)", (source_dir / "CMakeLists.txt").read_text(), re.MULTILINE)[1]
    assert run("dpkg-deb", "--field", packages["curv"], "Version").strip() == version
    run("lintian", "--fail-on", "error,warning", "--allow-root", *packages.values())


def readme_commands(source_dir):
    """README's shell blocks, as somebody types them who has installed the packages."""
    snippets = re.findall(r"^```sh\n(.*?)^```$", (source_dir / "README.md").read_text(encoding="utf-8"),
                          re.MULTILINE | re.DOTALL)
    code = "".join(snippets).replace("build/release/bin/", "")
    assert "curv estimate" in code and "curv info" in code, code
    return code


def flags_of(*command):
    return set(re.findall(r"(?<![\w-])--[a-z][a-z-]+", run(*command, "--help")))


def check_man_pages():
    """Both are free of warnings, are found by name, and explain every flag."""
    commands = re.findall(r"^  ([a-z]+) ", run("curv", "--help").partition("Subcommands:")[2], re.MULTILINE)
    pages = {("curv", 1): flags_of("curv").union(*(flags_of("curv", command) for command in commands)),
             ("curvd", 8): flags_of("curvd")}
    for (name, section), flags in pages.items():
        page = run("man", "--where", str(section), name).strip()
        warnings = subprocess.run(["man", "--warnings", "--encoding=UTF-8", "-Tutf8", "-Z", "--local-file", page],
                                  check=True, capture_output=True, text=True, env={**os.environ, "LC_ALL": "C.UTF-8"}).stderr
        assert not warnings, warnings
        text = re.sub(r"\\[fe][BIR]?", "", run("zcat", page)).replace("\\-", "-")
        missing = [flag for flag in flags if not re.search(rf"(?<![\w-]){flag}(?![\w-])", text)]
        assert not missing, f"{name}({section}) lacks {missing}"
        print(run("lexgrog", page).strip())


def use(curvd, user, code, environment):
    """Runs the commands against a curvd, which must drain well at SIGTERM."""
    with tempfile.TemporaryDirectory() as folder:
        with debian_machine.serving([curvd], user, environment):
            print(run("bash", "-euo", "pipefail", "-c", code, cwd=folder, env=environment))
        assert {"curvature.ply", "curvature.png", "curvature.html"} <= set(os.listdir(folder))


def check_installed():
    owner = os.stat("/etc/curvd")
    assert stat.S_IMODE(owner.st_mode) == 0o2750, oct(owner.st_mode)
    assert run("stat", "--format=%U:%G", "/etc/curvd").strip() == "root:curvd"
    assert os.path.islink("/etc/systemd/system/multi-user.target.wants/curvd.service"), "is not enabled"
    told = run("systemd-analyze", "verify", "curvd.service", stderr=subprocess.STDOUT)
    assert not told, told
    rated = run("systemd-analyze", "security", "--offline=true", "curvd.service")
    exposure = float(re.search(r"Overall exposure level for curvd.service: ([\d.]+)", rated)[1])
    assert exposure <= MOST_EXPOSURE, rated
    print(f"curvd.service: exposure {exposure}")


def check_removal(packages):
    """An administrator's settings and files outlive a removal, and the files a purge."""
    pathlib.Path("/etc/curvd/tokens").write_text("alice sha256:00\n", encoding="ascii")
    with open("/etc/default/curvd", "a", encoding="ascii") as settings:
        settings.write("CURVD_THREADS=1\n")
    run("dpkg", "--install", packages["curvd"])
    assert "CURVD_THREADS=1" in pathlib.Path("/etc/default/curvd").read_text(encoding="ascii"), "settings are gone"
    run("dpkg", "--remove", "curvd", "curv")
    assert os.path.exists("/etc/default/curvd") and not os.path.exists("/usr/bin/curvd")
    run("dpkg", "--purge", "curvd", "curv", "libcurvd-client-dev")
    assert not os.path.exists("/etc/default/curvd")
    assert not os.path.lexists("/etc/systemd/system/multi-user.target.wants/curvd.service")
    assert os.listdir("/etc/curvd") == ["tokens"]


def try_installed(source_dir, folder):
    """Runs in namespaces of its own; see main."""
    code = readme_commands(source_dir)
    debian_machine.enter(folder)
    packages = {path.name.split("_")[0]: path for path in pathlib.Path("/mnt").glob("*.deb")}
    print(run("dpkg", "--install", *packages.values()))
    assert not run("dpkg", "--audit", *packages), "dpkg finds faults"
    check_installed()
    check_man_pages()
    use("/usr/bin/curvd", "curvd", code, {"PATH": "/usr/bin:/bin", "HOME": "/root"})
    check_removal(packages)


def try_unpacked(source_dir, packages, folder):
    for name in ("curvd", "curv"):
        run("dpkg-deb", "--extract", packages[name], folder / "root")
    code = readme_commands(source_dir)
    environment = {**os.environ, "PATH": f"{folder}/root/usr/bin:{os.environ['PATH']}"}
    for default, port in zip(("50061", "9461"), debian_machine.free_ports()):
        code = code.replace(default, port)
        environment[f"CURVD_{'METRICS_' if default == '9461' else ''}LISTEN"] = f"127.0.0.1:{port}"
    use(folder / "root/usr/bin/curvd", None, code, environment)


def main():
    source_dir, build_dir = map(pathlib.Path, sys.argv[1:])
    if not build_dir.joinpath("CMakeCache.txt").exists():  # called again, in namespaces
        return try_installed(source_dir, build_dir)
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        packages = build(source_dir, build_dir, folder)
        check_contents(packages, source_dir)
        if os.geteuid() == 0:
            print(run("unshare", "--mount", "--net", "--propagation=private", sys.executable, "-B", __file__, source_dir,
                      folder))
        else:
            print("not root: the packages are unpacked, not installed")
            try_unpacked(source_dir, packages, folder)
    return 0


if __name__ == "__main__":
    sys.exit(main())
