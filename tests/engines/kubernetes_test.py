#!/usr/bin/python3
"""Checks deploy/engines/kubernetes, and runs the command of each pod: kubernetes_test.py SOURCE_DIR CURV CURVD

Fields and their types are compared with those of Kubernetes' client for Python (Debian's python3-kubernetes, of Kubernetes 1.22),
and kubectl makes the manifests where it is installed; else they are read as they are. The commands run as the kubelet would run
them, with the variable of their index, on a server with TLS and tokens; there is no cluster.
"""

import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

import yaml

SOURCE_DIR, CURV, CURVD = pathlib.Path(sys.argv[1]), *map(os.path.abspath, sys.argv[2:4])
FOLDER = SOURCE_DIR / "deploy" / "engines" / "kubernetes"
INDEXED = SOURCE_DIR / "deploy" / "engines" / "kubernetes-indexed"
sys.path[:0] = [str(SOURCE_DIR / "tests" / "fault"), str(SOURCE_DIR / "tests" / "languages"), str(SOURCE_DIR / "tests" / "docs")]

from curvd_process import Curvd
from snippets import blocks
from with_curvd import make_secrets

try:
    import kubernetes.client as kubernetes
except ImportError:
    kubernetes = None


def indexed_job():
    """The Job of the variant with one tile a pod: the base with the patches applied, which are of two kinds."""
    job = next(part for part in manifests() if part["kind"] == "Job")
    patches = yaml.safe_load((INDEXED / "kustomization.yaml").read_text(encoding="utf-8"))["patches"]
    for step in (step for each in patches for step in yaml.safe_load(each["patch"])):
        *path, last = (int(word) if word.isdigit() else word for word in step["path"][1:].split("/"))
        place = job
        for word in path:
            place = place[word]
        if last == "-":
            place.append(step["value"])
        else:
            place[last] = step["value"]
    return job


def manifests():
    if shutil.which("kubectl"):
        made = subprocess.run(["kubectl", "kustomize", FOLDER], check=True, capture_output=True, text=True).stdout
        return list(yaml.safe_load_all(made))
    listed = yaml.safe_load((FOLDER / "kustomization.yaml").read_text(encoding="utf-8"))["resources"]
    return [part for name in listed for part in yaml.safe_load_all((FOLDER / name).read_text(encoding="utf-8"))]


def faults(value, kind, where):
    """Where a manifest is not of a type of the client's: "str", "list[V1Container]", "dict(str, str)", "V1JobSpec"."""
    listed, mapped = re.fullmatch(r"list\[(.*)\]", kind), re.fullmatch(r"dict\(str, (.*)\)", kind)
    if listed:
        if not isinstance(value, list):
            return [f"{where}: {value!r} is no list"]
        return [fault for i, each in enumerate(value) for fault in faults(each, listed[1], f"{where}[{i}]")]
    if mapped:
        return [fault for key, each in value.items() for fault in faults(each, mapped[1], f"{where}.{key}")]
    if not hasattr(kubernetes, kind):
        types = {"int": int, "bool": bool, "str": str}.get(kind, object)
        return [] if isinstance(value, types) and (kind != "int" or not isinstance(value, bool)) else [f"{where}: {value!r} is no {kind}"]
    model = getattr(kubernetes, kind)
    known = {key: model.openapi_types[name] for name, key in model.attribute_map.items()}
    if not isinstance(value, dict):
        return [f"{where}: {value!r} is no {kind}"]
    found = [f"{where}.{key}: there is no such field" for key in value if key not in known]
    return found + [fault for key, each in value.items() if key in known for fault in faults(each, known[key], f"{where}.{key}")]


class Manifests(unittest.TestCase):
    def setUp(self):
        self.objects = {part["kind"]: part for part in manifests()}
        self.pod = self.objects["Job"]["spec"]["template"]
        self.container = self.pod["spec"]["containers"][0]

    @unittest.skipUnless(kubernetes, "python3-kubernetes is not installed")
    def test_fields_and_types_are_those_of_kubernetes(self):
        self.assertEqual(set(self.objects), {"Job", "HorizontalPodAutoscaler"})
        for name, part in self.objects.items():
            self.assertEqual(faults(part, f"V1{name}", name), [])
        wrong = {**self.objects["Job"]["spec"], "completionmode": "Indexed", "completions": "3"}
        self.assertEqual(faults(wrong, "V1JobSpec", "spec"),
                         ["spec.completionmode: there is no such field", "spec.completions: '3' is no int"])

    @unittest.skipUnless(shutil.which("kubectl"), "kubectl is not installed")
    def test_the_variant_is_what_kubectl_makes_of_it(self):
        made = subprocess.run(["kubectl", "kustomize", INDEXED], check=True, capture_output=True, text=True).stdout
        self.assertIn(indexed_job(), list(yaml.safe_load_all(made)))

    def test_pods_share_the_tiles_or_have_one_each(self):
        spec, indexed = self.objects["Job"]["spec"], indexed_job()["spec"]
        self.assertNotIn("completionMode", spec)
        self.assertEqual(spec["completions"], spec["parallelism"])
        self.assertFalse([word for word in self.container["args"] if word.startswith("--tile")])
        self.assertEqual(indexed["completionMode"], "Indexed")
        self.assertIn("--tile=$(JOB_COMPLETION_INDEX)", indexed["template"]["spec"]["containers"][0]["args"])
        self.assertIn(self.pod["spec"]["restartPolicy"], ("OnFailure", "Never"))
        if kubernetes:
            self.assertEqual(faults(indexed_job(), "V1Job", "Job"), [])

    def test_flags_exist_and_ask_for_tls_and_a_token(self):
        told = subprocess.run([CURV, "tiles", "run", "--help"], check=True, capture_output=True, text=True).stdout
        flags = {argument.split("=")[0] for argument in self.container["args"] if argument.startswith("--")}
        self.assertLessEqual(flags, set(re.findall(r"--[a-z-]+", told)))
        self.assertLessEqual({"--ca", "--token-file"}, flags)

    def test_pods_may_do_nothing_else_and_call_the_servers(self):
        pod, container = self.pod["spec"]["securityContext"], self.container["securityContext"]
        self.assertEqual((pod["runAsNonRoot"], pod["runAsUser"], pod["seccompProfile"]["type"]), (True, 65532, "RuntimeDefault"))
        self.assertEqual((container["allowPrivilegeEscalation"], container["readOnlyRootFilesystem"]), (False, True))
        self.assertEqual(container["capabilities"], {"drop": ["ALL"]})
        servers = {part["kind"]: part for part in
                   yaml.safe_load_all((SOURCE_DIR / "deploy" / "kubernetes.yaml").read_text(encoding="utf-8"))}
        let_in = servers["NetworkPolicy"]["spec"]["ingress"][0]["from"][0]["podSelector"]["matchLabels"]
        self.assertLessEqual(let_in.items(), self.pod["metadata"]["labels"].items())
        host, port = next(argument for argument in self.container["args"] if argument.startswith("--server="))[9:].split(":")
        self.assertEqual((host, int(port)), (servers["Service"]["metadata"]["name"], servers["Service"]["spec"]["ports"][0]["port"]))
        self.assertEqual(self.container["image"], servers["Deployment"]["spec"]["template"]["spec"]["containers"][0]["image"])
        self.assertEqual(self.objects["HorizontalPodAutoscaler"]["spec"]["scaleTargetRef"]["name"], servers["Deployment"]["metadata"]["name"])

    def test_every_mount_is_a_volume(self):
        self.assertEqual({mount["name"] for mount in self.container["volumeMounts"]},
                         {volume["name"] for volume in self.pod["spec"]["volumes"]})

    def test_the_commands_are_five_at_most_and_name_the_folders(self):
        told = [next(code for kind, code in blocks(document) if kind == wanted) for document, wanted in
                ((FOLDER / "README.md", "text"), (SOURCE_DIR / "docs" / "scale.md", "text kubernetes"))]
        self.assertEqual(told[0], told[1])
        self.assertLessEqual(len(told[0].splitlines()), 5)
        self.assertIn("kubectl apply -k deploy/engines/kubernetes\n", told[0])
        command = next(code for kind, code in blocks(FOLDER / "README.md") if kind == "text indexed")
        self.assertIn("kubectl kustomize deploy/engines/kubernetes-indexed |", command)
        self.assertRegex(yaml.safe_dump(indexed_job()), "(?m)" + re.search(r'sed "s/(completions: 1\$)/', command)[1])


class Pods(unittest.TestCase):
    def test_what_they_run_gives_the_bytes_of_the_whole_cloud(self):
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            flags = [flag for flag in make_secrets(folder) if not flag.startswith("--tls-client-ca")]
            (folder / "ca.crt").write_bytes((folder / "server.crt").read_bytes())

            def curv(*arguments):
                return subprocess.run([CURV, *map(str, arguments)], check=True, capture_output=True, text=True, cwd=folder).stdout

            curv("generate", "goursat", "--points=6000", "-o", "large.ply")
            curv("estimate", "large.ply", "-o", "whole.ply", "--threads=1")
            with Curvd(CURVD, "--threads=1", *flags) as server:
                here = {"/tiles/": f"{folder}/", "/etc/curvd-client/": f"{folder}/", "curvd:50061": server.address}

                def run_pod(job, index=""):
                    container = job["spec"]["template"]["spec"]["containers"][0]
                    words = [*container["command"], *container["args"]]
                    for there, ours in {"$(JOB_COMPLETION_INDEX)": index, **here}.items():
                        words = [word.replace(there, ours) for word in words]
                    self.assertEqual(words[0], "curv")
                    return subprocess.Popen([CURV, *words[1:]], stdout=subprocess.DEVNULL)

                for job in (next(part for part in manifests() if part["kind"] == "Job"), indexed_job()):
                    curv("tiles", "plan", "large.ply", "-o", "work", "--tile-points=2000")
                    indexed = "completionMode" in job["spec"]
                    indices = curv("tiles", "status", "work", "--left").split() if indexed else [""] * 2
                    for pod in [run_pod(job, index) for index in indices]:
                        self.assertEqual(pod.wait(), 0)
                    curv("tiles", "merge", "work", "-o", "merged.ply")
                    self.assertEqual((folder / "merged.ply").read_bytes(), (folder / "whole.ply").read_bytes())
                    shutil.rmtree(folder / "work")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
