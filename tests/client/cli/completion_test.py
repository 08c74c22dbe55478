#!/usr/bin/python3
"""Types command lines of curv into bash, zsh and fish and presses the tab key: completion_test.py CURV

bash and zsh run in a terminal of their own, as a person sees them; what they made of the line is what they run. fish tells its
completions without one. A shell that is not installed fails the test.
"""

import os
import pathlib
import pty
import re
import select
import subprocess
import sys
import tempfile
import time
import unittest

CURV = os.path.abspath(sys.argv[1])
ANSWER_SECONDS = 20


class Shell:
    """An interactive shell that has read curv's script, in a terminal."""

    def __init__(self, command, setup, folder):
        self._command = command
        pid, self._terminal = pty.fork()
        if pid == 0:
            os.chdir(folder)
            os.environ.update(PATH=f"{os.path.dirname(CURV)}:/usr/bin:/bin", TERM="dumb", HOME=folder, LC_ALL="C.UTF-8")
            os.execvp(command[0], command)
        self._pid = pid
        self._send(f"{setup}; echo re''ady\n")
        self._read_until("ready")

    def _send(self, keys):
        os.write(self._terminal, keys.encode())

    def _read_until(self, wanted):
        text, give_up = "", time.monotonic() + ANSWER_SECONDS
        while wanted not in text:
            left = give_up - time.monotonic()
            if left <= 0 or not select.select([self._terminal], [], [], left)[0]:
                raise AssertionError(f"{self._command[0]} did not answer {wanted!r}: {text!r}")
            text += os.read(self._terminal, 65536).decode()
        return text

    def completed(self, typed, key="\t"):
        """The line after the key, as the shell then takes it apart into words."""
        self._send(f"words {typed}{key}\n")
        text = self._read_until(">>")
        return re.search(r"<<(.*?)>>", text, re.DOTALL)[1].strip()

    def close(self):
        os.close(self._terminal)
        os.waitpid(self._pid, 0)


def shell_script(name):
    return subprocess.run([CURV, "completion", name], check=True, capture_output=True, text=True).stdout


# Prints the line that a person would have run. The name stands for curv, so that nothing is run.
WORDS = r"words() { local all=curv each; for each; do all=\"$all ${each// /\\ }\"; done; printf '%s%s>>\n' '<''<' \"$all\"; }"


class CompletionTest(unittest.TestCase):
    def setUp(self):
        holder = tempfile.TemporaryDirectory()
        self.addCleanup(holder.cleanup)
        self._folder = pathlib.Path(holder.name)
        for name in ("scan.ply", "a scan.las"):
            (self._folder / name).write_text("", encoding="utf-8")
        (self._folder / "results").mkdir()
        for name in ("bash", "zsh", "fish"):
            (self._folder / f".{name}").write_text(shell_script(name), encoding="utf-8")

    def _shell(self, command, setup):
        shell = Shell(command, setup + "; " + WORDS.replace('\\"', '"'), str(self._folder))
        self.addCleanup(shell.close)
        return shell

    def _bash(self, before=""):
        # The function completes the first word whatever it is called.
        setup = f"PS1=; {before} bind 'set enable-bracketed-paste off'; source .bash; complete -F _curv words"
        return self._shell(["bash", "--norc", "--noprofile", "-i"], setup)

    def _check_each(self, shell, expected):
        for typed, line in expected.items():
            with self.subTest(typed):
                self.assertEqual(shell.completed(typed), line)

    def test_bash(self):
        self._check_each(self._bash(), {
            "est": "curv estimate",
            "--ver": "curv --version",
            "estimate sc": "curv estimate scan.ply",
            "estimate a": "curv estimate a\\ scan.las",  # one word
            "estimate scan.ply -o res": "curv estimate scan.ply -o results/",
            "estimate --estimator hexa": "curv estimate --estimator hexagram",
            "estimate --estimator=norm": "curv estimate --estimator=normal-regression",
            "estimate --color=gau": "curv estimate --color=gaussian",
            "estimate --quantities=mean,curv": "curv estimate --quantities=mean,curvedness",
            "estimate --norm": "curv estimate --normal",  # --normals, --normal-method, ...
            "estimate --normals=orient --normal-m": "curv estimate --normals=orient --normal-method",
            "estimate --token-file=sc": "curv estimate --token-file=scan.ply",
            "generate ell": "curv generate ellipsoid",
            "render scan.ply --quantity=gau": "curv render scan.ply --quantity=gaussian",
            "completion z": "curv completion zsh",
            "tiles ver": "curv tiles verify",
            "tiles run res": "curv tiles run results/",
            "tiles plan --estimator=norm": "curv tiles plan --estimator=normal-regression",
            "tiles --he": "curv tiles --help",
            "estimate plan --tim": "curv estimate plan --timeout",  # plan is a command of tiles alone
            "estimate --timeout s": "curv estimate --timeout s",  # a number: nothing is offered
        })

    def test_bash_lists_all_that_is_possible(self):
        shell, all_of_them = self._bash(), "\x1b*"
        self.assertEqual(shell.completed("completion ", all_of_them), "curv completion bash fish zsh")
        self.assertEqual(shell.completed("estimate --priority=b", all_of_them), "curv estimate --priority=batch")
        self.assertEqual(shell.completed("generate s", all_of_them), "curv generate saddle sphere")

    def test_bash_that_leaves_words_at_equal_signs_whole(self):
        self._check_each(self._bash("COMP_WORDBREAKS=${COMP_WORDBREAKS//=};"), {
            "estimate --estimator=norm": "curv estimate --estimator=normal-regression",
            "estimate --quantities=mean,curv": "curv estimate --quantities=mean,curvedness",
        })

    def test_zsh(self):
        setup = "PS1=; PS2=; unsetopt zle_bracketed_paste; autoload -U compinit; compinit -D -u; source ./.zsh; compdef _curv words"
        self._check_each(self._shell(["zsh", "-f", "-i"], setup), {
            "est": "curv estimate",
            "estimate sc": "curv estimate scan.ply",
            "estimate scan.ply -o res": "curv estimate scan.ply -o results",  # zsh takes the slash away again
            "estimate --estimator hexa": "curv estimate --estimator hexagram",
            "estimate --estimator=norm": "curv estimate --estimator=normal-regression",
            "estimate --quantities=mean,curv": "curv estimate --quantities=mean,curvedness",
            "generate ell": "curv generate ellipsoid",
            "completion f": "curv completion fish",
            "tiles ver": "curv tiles verify",
            "tiles run res": "curv tiles run results",
            "tiles plan --estimator=norm": "curv tiles plan --estimator=normal-regression",
        })

    def _fish(self, typed):
        told = subprocess.run(["fish", "--no-config", "-c", f"source .fish; complete -C '{typed}'"], check=True,
                              capture_output=True, text=True, cwd=self._folder, env={**os.environ, "HOME": str(self._folder)})
        self.assertEqual(told.stderr, "")
        return [line.split("\t")[0] for line in told.stdout.splitlines()]

    def test_fish(self):
        for typed, offered in {
            "curv est": ["estimate"],
            "curv estimate sc": ["scan.ply"],
            "curv estimate scan.ply -o res": ["results/"],
            "curv estimate --estimator hexa": ["hexagram"],
            "curv estimate --estimator=norm": ["--estimator=normal-regression"],
            "curv generate s": ["saddle", "sphere"],
            "curv completion z": ["zsh"],
            "curv tiles ": ["merge", "plan", "run", "status", "verify"],
            "curv tiles run res": ["results/"],
            "curv tiles run --ti": ["--tile", "--timeout"],
            "curv tiles plan --estimator=norm": ["--estimator=normal-regression"],
        }.items():
            with self.subTest(typed):
                self.assertEqual(self._fish(typed), offered)

    def test_every_flag_of_every_command_is_offered(self):
        commands = list(self._commands())
        self.assertGreater(len(commands), 15)
        script = shell_script("bash")
        for command in commands:
            offered = re.search(rf"^ +'{command}'\) .* flags='(.*)' ;;$", script, re.MULTILINE)[1].split()
            flags = re.findall(r"^  (?:-\w,)?(--[a-z-]+)", self._help(*command.split()), re.MULTILINE)
            self.assertEqual([flag for flag in offered if flag.startswith("--")], flags, command)

    def test_every_placeholder_is_a_file_or_known_to_be_none(self):
        files = {"FILE", "IN", "IN...", "OUT", "RESULT", "PNG", "HTML", "DIR"}
        others = {"AXIS", "CONDITION", "COUNT", "DEGREE", "FACTOR", "FORMAT", "LEAST:MOST", "LENGTH", "LIST", "LO:HI", "LO:HI,...", "NAME", "NAME,...", "NUMBER",
                  "POLICY", "PORT", "PRIORITY", "PROGRAM", "SECONDS", "SHELL", "SIGMA", "SIZE", "SOURCE", "SURFACE", "TEXT", "VIEW", "WEIGHT",
                  "WIDTHxHEIGHT", "X,Y,Z"}
        found = set()
        for command in self._commands():
            found |= set(re.findall(r"^  (?:-\w,)?[a-z-]+ ([A-Z][^\s=]*)(?: |$)", self._help(*command.split()), re.MULTILINE))
        self.assertEqual({word for word in found if not word.endswith(":")} - files - others, set())

    def _commands(self, *group):
        """The names of all commands, "tiles plan" of one within another."""
        section = self._help(*group).partition("Subcommands:")[2].partition("\n\n")[0]
        for word in re.findall(r"^  ([a-z]+) ", section, re.MULTILINE):
            yield " ".join([*group, word])
            yield from self._commands(*group, word)

    def _help(self, *command):
        return subprocess.run([CURV, *command, "--help"], check=True, capture_output=True, text=True).stdout


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
