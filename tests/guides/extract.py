#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes the snippets of pages as files, and prints their names: extract.py LANGUAGE FOLDER PAGE…

Block n of docs/NAME.md becomes FOLDER/NAME_n.LANGUAGE. Files that would not change are left alone, so that they are not compiled anew.
"""
import pathlib
import re
import sys

language, folder, *pages = sys.argv[1:]
for page in map(pathlib.Path, pages):
    blocks = re.findall(rf"^```{language}\n(.*?)^```", page.read_text(encoding="utf-8"), re.M | re.S)
    if not blocks:
        sys.exit(f"{page} holds no {language} snippet")
    for number, text in enumerate(blocks, 1):
        file = pathlib.Path(folder, f"{page.stem}_{number}.{language}")
        if not file.exists() or file.read_text(encoding="utf-8") != text:
            file.write_text(text, encoding="utf-8")
        print(file.name)
