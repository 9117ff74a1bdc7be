#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""docs/algorithms.md shows the constants of `cells` as constants.hpp has them. With --write the table is made anew.

Environment: FRANSAC_SOURCE_DIR, the tree.
"""

import os
import pathlib
import re
import sys

ROOT = pathlib.Path(os.environ.get("FRANSAC_SOURCE_DIR", pathlib.Path(__file__).resolve().parents[2]))
HEADER = ROOT / "src/planes/cells/constants.hpp"
PAGE = ROOT / "docs/algorithms.md"
BLOCK = re.compile(r"(<!-- constants -->\n).*?(<!-- end -->)", re.S)


def table(header):
    """One line per comment of the list, with the constants up to the next comment."""
    body = re.search(r"#define FRANSAC_CELLS_CONSTANTS\(X\)(.*?)\n\n", header, re.S)[1]
    lines = ["| constants | |", "| --- | --- |"]
    # A comment, its constants, the next comment …
    _, *parts = re.split(r"/\*(.*?)\*/", body.replace("\\\n", " "), flags=re.S)
    for reason, constants in zip(parts[::2], parts[1::2]):
        found = re.findall(r"X\((\w+), ([^)]+)\)", constants)
        shown = ", ".join(f"`{name}` {value}" for name, value in found)
        lines.append(f"| {shown} | {' '.join(reason.split())} |")
    return "\n".join(lines) + "\n"


def main():
    page = PAGE.read_text(encoding="utf-8")
    header = HEADER.read_text(encoding="utf-8")
    shown = re.findall(r"`(\w+)` [\d.]+", table(header))
    assert shown == re.findall(r"^(?!///).*?\bX\((\w+), [\d.]+\)", re.sub(r"\) X\(", ")\nX(", header), re.M), "some are overlooked"
    assert len(BLOCK.findall(page)) == 1, f"{PAGE}: has no place for the table"
    filled = BLOCK.sub(lambda match: match[1] + table(header) + match[2], page)
    if "--write" in sys.argv:
        PAGE.write_text(filled, encoding="utf-8")
    elif page != filled:
        sys.exit(f"{PAGE}: the constants are others in {HEADER}; run {pathlib.Path(__file__).relative_to(ROOT)} --write")
    prose = BLOCK.sub("", page)
    for name in re.findall(r"`([a-z]+(?:_[a-z]+)+)`", prose[prose.index("\n## Cells\n") : prose.index("\n## Outlines\n")]):
        assert f"X({name}, " in header, f"{PAGE}: there is no constant {name}"


main()
