#!/usr/bin/python3
"""Makes a man page of what a program says with --help, and of what its subcommands say.

  man_page.py PROGRAM SECTION WHATIS > PAGE      as man_page.py build/release/bin/curv 1 "curvature of point clouds"

SOURCE_DATE_EPOCH tells the page's date, else it is today's. help2man reads no options such as "-o,--output", of which CLI11
makes help, and no subcommands.
"""

import os
import re
import subprocess
import sys
import time

SEE_ALSO = {"curv": "curvd(8)", "curvd": "curv(1)"}
SHARED_FOOTER = "Exit codes: "


def told(program, *words):
    return subprocess.run([program, *words, "--help"], check=True, capture_output=True, text=True).stdout


def roff(text):
    """Text that stands for itself, at the beginning of a line too."""
    text = text.replace("\\", "\\e").replace("-", "\\-")
    return "\\&" + text if text.startswith((".", "'")) else text


class Help:
    """What one --help says: its description, usage, sections of terms, and the lines that follow them."""

    def __init__(self, text):
        head, _, rest = text.partition("Usage: ")
        self.description = head.split("\n\n")[0].strip()
        self.usage, _, rest = rest.partition("\n")
        # Where the explanations stand, of which that of --help is always there.
        self._column = len(re.search(r"^  -h,--help +", text, re.MULTILINE)[0])
        self.sections, self.footer = {}, []
        name = None
        for line in rest.splitlines():
            if re.fullmatch(r"(Positionals|Options|Subcommands):", line):
                name = line[:-1]
                self.sections[name] = []
            elif name and line.startswith("  "):
                self._add_term(self.sections[name], line)
            elif name and line == "" or name is None:
                name = None
                self.footer.append(line)

    def _add_term(self, terms, line):
        if line.startswith(" " * self._column):
            terms[-1][1] += line.strip()
        elif line[self._column - 1:self._column] == " ":
            terms.append([line[:self._column].strip(), line[self._column:].strip()])
        else:
            terms.append([line.strip(), ""])


def italic(text):
    return f"\\fI{roff(text)}\\fR" if text else ""


def option(term, explanation):
    """One flag, as --help tells it: "-o,--output OUT=a (Env:CURV_OUT) Excludes: --b"."""
    parsed = re.fullmatch(r"(-\S+?)(\{\S+\})?(?: ((?!\(Env|Excludes)[^\s=]+)(?:=(\S+))?)?( \[.*?\])?(?: \(Env:(\S+)\))?"
                          r"(?: Excludes: (.*))?", term)
    names, optional, placeholder, default, bracketed, variable, others = parsed.groups()
    yield ".TP"
    shown = ", ".join(f"\\fB{roff(name)}\\fR" for name in names.split(","))
    shown += f"[={italic(optional[1:-1])}]" if optional else ""
    shown += f" {italic(placeholder)}" if placeholder else ""
    yield shown + roff(bracketed or "")
    yield roff(explanation or "None.")
    remarks = [f"Default: {default}."] if default else []
    remarks += [f"Environment: {variable}."] if variable else []
    remarks += [f"Not together with {', '.join(others.split())}."] if others else []
    if remarks:
        yield ".br"
        yield roff(" ".join(remarks))


def terms(section):
    for term, explanation in section:
        if term.startswith("-"):
            yield from option(term, explanation)
        else:
            yield from (".TP", f"\\fI{roff(term)}\\fR", roff(explanation))


def prose(lines):
    """Paragraphs; lines that are indented stay as they are."""
    shown = False
    for line in lines:
        if line.startswith("  ") != shown:
            shown = not shown
            yield from ([".PP", ".RS 4", ".nf"] if shown else [".fi", ".RE", ".PP"])
        elif not shown and (not line or re.match(r"[A-Z][a-z]+( [a-z]+)?: ", line)):
            yield ".PP"
        if line:
            yield roff(line[2:] if shown else line)
    if shown:
        yield from (".fi", ".RE")


def split_footer(lines):
    """What a command says at the end of its --help; and its exit codes, which are those of all."""
    text = "\n".join(lines).strip("\n")
    own, _, codes = text.partition(SHARED_FOOTER)
    return own.strip("\n").splitlines(), " ".join(codes.split())


def exit_status(codes):
    yield ".SH EXIT STATUS"
    for code in re.split(r"; (?=\d)", codes.rstrip(".")):
        number, _, meaning = code.partition(" ")
        yield from (".TP", f"\\fB{number}\\fR", roff(meaning))


def command_section(program, name):
    """A command, and those within it: "tiles", "tiles plan"."""
    command = Help(told(program, *name.split()))
    yield f".SS {roff(os.path.basename(program))} {roff(name)}"
    yield roff(command.description + ".")
    yield ".PP"
    yield f"\\fB{roff(command.usage)}\\fR"
    for section in ("Positionals", "Options"):
        yield from terms(entry for entry in command.sections.get(section, []) if entry[0] != "-h,--help")
    own, _ = split_footer(command.footer)
    if own:
        yield ".PP"
        yield from prose(own)
    for word, _ in command.sections.get("Subcommands", []):
        yield from command_section(program, f"{name} {word}")


def page(program, section, whatis):
    name = os.path.basename(program)
    whole = Help(told(program))
    own, codes = split_footer(whole.footer)
    date = time.strftime("%Y-%m-%d", time.gmtime(int(os.environ.get("SOURCE_DATE_EPOCH", time.time()))))
    version = subprocess.run([program, "--version"], check=True, capture_output=True, text=True).stdout.split(" (")[0]
    yield '.\\" Made of what --help says, by deploy/debian/man_page.py.'
    yield f'.TH {name.upper()} {section} "{date}" "{roff(version)}" "curvd"'
    yield from (".SH NAME", f"{name} \\- {roff(whatis)}", ".SH SYNOPSIS", f"\\fB{roff(whole.usage)}\\fR")
    yield from (".SH DESCRIPTION", *prose(whole.description.splitlines()))
    yield from (".SH OPTIONS", *terms(whole.sections["Options"]))
    if "Subcommands" in whole.sections:
        yield ".SH COMMANDS"
        for command, _ in whole.sections["Subcommands"]:
            yield from command_section(program, command)
    if own:
        yield from (".SH NOTES", *prose(own))
    if codes:
        yield from exit_status(codes)
    yield from (".SH SEE ALSO", roff(SEE_ALSO[name]))


def main():
    program, section, whatis = sys.argv[1:]
    print("\n".join(page(program, section, whatis)))


if __name__ == "__main__":
    main()
