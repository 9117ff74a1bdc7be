#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""No installed text file may name a folder of the build: check_relocatable.py PREFIX FOLDER..."""

import pathlib
import sys

prefix, *folders = sys.argv[1:]
files = [f for f in pathlib.Path(prefix).rglob("*") if f.suffix in (".cmake", ".hpp", ".pc")]
found = [f"{f}: names {folder}" for f in files for folder in folders if folder in f.read_text(encoding="utf-8")]
strangers = [f"{f}: not meant to be installed" for f in pathlib.Path(prefix).rglob("*.in")]
if not files:
    sys.exit(f"{prefix}: nothing is installed")
if not any(f.name == "version.hpp" for f in files):
    sys.exit(f"{prefix}: version.hpp is missing")
sys.exit("\n".join(found + strangers) or 0)
