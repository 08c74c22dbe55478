#!/usr/bin/python3
"""Follows the links between the documents, and what sources say is found in one: files exist, and so do headings.

  links_test.py SOURCE_FOLDER
"""

import pathlib
import re
import sys

ROOMS = ["core", "server", "client", "proto", "tests", "bench", "deploy", "docs", "about", "cmake"]
SOURCES = {".h", ".cc", ".py", ".proto", ".mjs", ".js", ".ts", ".sh", ".yml", ".yaml", ".txt"}
FENCE = re.compile(r"^ *```.*?^ *```", re.MULTILINE | re.DOTALL)
# [text](target), where the text may hold a picture or be broken into lines.
LINK = re.compile(r"\]\(([^)\s]+)\)")
# As comments, messages and runbooks name a page, and maybe a heading of it.
NAMED = re.compile(r"docs/[\w/]+\.md(?:#[\w-]+)?")


def anchors(page, known={}):
    if page not in known:
        text = FENCE.sub("", page.read_text(encoding="utf-8"))
        headings = re.findall(r"^#+ +(.*?) *$", text, re.MULTILINE)
        known[page] = {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}
    return known[page]


def fault_of(target, folder):
    """What is wrong with a link to a file, from a page or source in the folder; None: nothing."""
    path, _, anchor = target.partition("#")
    page = (folder / path).resolve()
    if not page.exists():
        return f"there is no {path}"
    if anchor and page.suffix == ".md" and anchor not in anchors(page):
        return f"{path} has no heading #{anchor}"
    return None


def links_of(root):
    """Pairs of a file and the target of a link in it, and the folder that the target starts from."""
    tops = [root / room for room in ROOMS]
    names = sorted(name for top in tops for name in top.rglob("*") if "node_modules" not in name.parts)
    for name in [*sorted(root.glob("*.md")), *names]:
        if name.suffix == ".md":
            for target in LINK.findall(FENCE.sub("", name.read_text(encoding="utf-8"))):
                if not re.match(r"[a-z]+:", target):
                    yield name, target if not target.startswith("#") else name.name + target, name.parent
        elif name.suffix in SOURCES and name.is_file():
            for target in NAMED.findall(name.read_text(encoding="utf-8")):
                yield name, target, root


def main():
    root = pathlib.Path(sys.argv[1])
    faults, checked = [], 0
    for name, target, folder in links_of(root):
        checked += 1
        fault = fault_of(target, folder)
        if fault:
            faults.append(f"{name.relative_to(root)} points to {target}: {fault}")
    for fault in faults:
        print(fault)
    print(f"{checked} links followed, {len(faults)} faults")
    return 1 if faults or checked < 100 else 0


if __name__ == "__main__":
    sys.exit(main())
