#!/usr/bin/python3
"""Checks what deploy/ promises: manifests_test.py SOURCE_DIR CURVD CURV

Every flag and variable of curvd there exists, and containers run as nobody, with a read-only root and no capability.
"""

import os
import pathlib
import re
import subprocess
import sys
import unittest

import yaml

SOURCE_DIR = pathlib.Path()
CURVD = CURV = ""


def flags_of(curvd):
    help_text = subprocess.run([curvd, "--help"], capture_output=True, text=True, check=True).stdout
    return set(re.findall(r"--[a-z-]+", help_text))


def packages_of_libraries(program):
    """The Debian packages of the shared libraries that a program asks for itself."""
    asked = subprocess.run(["readelf", "--dynamic", "--wide", program], capture_output=True, text=True, check=True).stdout
    names = set(re.findall(r"\(NEEDED\).*\[(\S+)\]", asked))
    loaded = subprocess.run(["ldd", program], capture_output=True, text=True, check=True).stdout
    paths = [os.path.realpath(path) for name, path in re.findall(r"(\S+) => (\S+)", loaded) if name in names]
    paths += [path.removeprefix("/usr") for path in paths]  # as packages name those that are older than the merge of both
    owners = subprocess.run(["dpkg-query", "--search", *paths], capture_output=True, text=True, check=False).stdout
    return set(re.findall(r"^([^:,\s]+)", owners, re.MULTILINE))


def variable(flag):
    return "CURVD_" + flag[2:].replace("-", "_").upper()


class DockerfileTest(unittest.TestCase):
    def setUp(self):
        self.text = (SOURCE_DIR / "Dockerfile").read_text(encoding="utf-8")

    def test_variables_are_those_of_flags(self):
        known = {variable(flag) for flag in flags_of(CURVD)}
        used = set(re.findall(r"(CURVD_[A-Z_]+)=", self.text))
        self.assertTrue(used)
        self.assertLessEqual(used, known)

    def test_installs_the_libraries_of_both_programs(self):
        installed = set(self.text[self.text.rindex("\nFROM "):].split()) | {"libc6", "libgcc-s1", "libstdc++6"}
        # Brought along, in the version that they were made with, by libgrpc++1.51 and libpango-1.0-0.
        installed |= {"libgrpc29", "libglib2.0-0", "libpango-1.0-0"}
        for program in (CURVD, CURV):
            asked = packages_of_libraries(program)
            self.assertIn("libprotobuf32", asked)
            self.assertFalse(asked - installed, f"{program} asks for packages that the image lacks")

    def test_runs_as_nobody_and_not_in_plain_text_by_itself(self):
        self.assertRegex(self.text, r"(?m)^USER 65532:65532$")
        self.assertNotIn("CURVD_INSECURE", self.text)


class ComposeTest(unittest.TestCase):
    def setUp(self):
        compose = yaml.safe_load((SOURCE_DIR / "deploy" / "compose.yaml").read_text(encoding="utf-8"))
        self.service = compose["services"]["curvd"]

    def test_may_do_nothing_but_serve(self):
        self.assertEqual(self.service["user"], "65532:65532")
        self.assertTrue(self.service["read_only"])
        self.assertEqual(self.service["cap_drop"], ["ALL"])
        self.assertEqual(self.service["security_opt"], ["no-new-privileges:true"])

    def test_plain_text_stays_on_this_machine(self):
        self.assertLessEqual(set(self.service["environment"]), {variable(flag) for flag in flags_of(CURVD)})
        for port in self.service["ports"]:
            self.assertTrue(port.startswith("127.0.0.1:"), port)


class KubernetesTest(unittest.TestCase):
    def setUp(self):
        text = (SOURCE_DIR / "deploy" / "kubernetes.yaml").read_text(encoding="utf-8")
        self.objects = {part["kind"]: part for part in yaml.safe_load_all(text)}
        self.pod = self.objects["Deployment"]["spec"]["template"]
        self.container = self.pod["spec"]["containers"][0]

    def test_flags_exist_and_ask_for_tls_and_tokens(self):
        flags = [argument.split("=")[0] for argument in self.container["args"]]
        self.assertLessEqual(set(flags), flags_of(CURVD))
        self.assertLessEqual({"--tls-cert", "--tls-key", "--token-file"}, set(flags))
        self.assertNotIn("--insecure", flags)

    def test_files_that_flags_name_are_mounted(self):
        folders = [mount["mountPath"] for mount in self.container["volumeMounts"]]
        for argument in self.container["args"]:
            flag, value = argument.split("=")
            if value.startswith("/"):
                self.assertIn(str(pathlib.PurePath(value).parent), folders, flag)

    def test_probes_ask_the_port_that_tells_health(self):
        for probe in ("startupProbe", "readinessProbe", "livenessProbe"):
            port = self.container[probe]["grpc"]["port"]
            self.assertIn(f"--health-listen=0.0.0.0:{port}", self.container["args"])

    def test_may_do_nothing_but_serve(self):
        pod, container = self.pod["spec"]["securityContext"], self.container["securityContext"]
        self.assertTrue(pod["runAsNonRoot"])
        self.assertEqual(pod["runAsUser"], 65532)
        self.assertEqual(pod["seccompProfile"]["type"], "RuntimeDefault")
        self.assertFalse(container["allowPrivilegeEscalation"])
        self.assertTrue(container["readOnlyRootFilesystem"])
        self.assertEqual(container["capabilities"], {"drop": ["ALL"]})
        self.assertFalse(self.pod["spec"]["automountServiceAccountToken"])
        self.assertIn("memory", self.container["resources"]["limits"])

    def test_an_image_that_was_loaded_need_not_be_pulled(self):
        self.assertEqual(self.container["imagePullPolicy"], "IfNotPresent")

    def test_selectors_find_the_pods(self):
        labels = self.pod["metadata"]["labels"]
        self.assertEqual(self.objects["Deployment"]["spec"]["selector"]["matchLabels"], labels)
        self.assertEqual(self.objects["Service"]["spec"]["selector"], labels)
        self.assertEqual(self.objects["NetworkPolicy"]["spec"]["podSelector"]["matchLabels"], labels)
        self.assertEqual(self.objects["PodDisruptionBudget"]["spec"]["selector"]["matchLabels"], labels)


if __name__ == "__main__":
    SOURCE_DIR, CURVD, CURV = pathlib.Path(sys.argv[1]), *sys.argv[2:]
    unittest.main(argv=sys.argv[:1])
