#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs the `fransac …` commands of a page as they stand there: page_test.py PAGE FRANSAC.

What they read (depth.png with its camera.json, scan.pcd, dataset) is rendered first. Runs and frames are cut down: this
tests that the commands work, not how fast.
"""
import pathlib
import re
import shlex
import shutil
import subprocess
import sys
import tempfile


def commands(page):
    """The lines of shell blocks that start with fransac."""
    blocks = re.findall(r"```sh\n(.*?)```", page, re.S)
    return [line.strip() for block in blocks for line in block.splitlines() if line.startswith("fransac ")]


def main():
    page, fransac = (pathlib.Path(argument).resolve() for argument in sys.argv[1:])
    found = commands(page.read_text(encoding="utf-8"))
    assert len(found) >= 2, f"{page} holds only {found}"
    with tempfile.TemporaryDirectory() as folder:

        def run(*arguments):
            done = subprocess.run([fransac, *arguments], cwd=folder, capture_output=True, text=True, check=False)
            assert done.returncode == 0, f"{arguments}: exit {done.returncode}: {done.stderr}"

        run("synth", "dataset", "--width", "160", "--height", "120")
        frame = next(pathlib.Path(folder, "dataset").glob("*/depth.png")).parent
        for name in ("depth.png", "camera.json"):
            shutil.copy(frame / name, folder)
        run("segment", "depth.png", "--cloud", "scan.pcd")
        for command in found:
            words = shlex.split(re.sub(r"--(frames|repeat) \d+", r"--\1 2", command), comments=True)
            run(*words[1:])
            for word in words:
                if word.endswith((".png", ".json", ".ply")):
                    assert pathlib.Path(folder, word).exists(), f"{command}: wrote no {word}"
    print(f"{len(found)} commands work")


main()
