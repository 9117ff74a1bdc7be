# SPDX-License-Identifier: Apache-2.0
"""Pages to look at. Environment: FRANSAC_APP, the program."""

import json
import os
import pathlib
import subprocess

METHODS = ("cells", "ransac", "rransac", "voxel-ransac", "fransac")


def fransac(folder, *arguments):
    """Runs the program and returns what it printed."""
    return subprocess.run([os.environ["FRANSAC_APP"], *arguments], cwd=folder, check=True, capture_output=True, text=True).stdout


def synth(folder, name="scenes", scene="desk", frames=2):
    fransac(folder, "synth", name, "--scene", scene, "--frames", str(frames), "--width", "160", "--height", "120", "--seed", "3")


def change_truth(folder, truth, name="scenes"):
    path = pathlib.Path(folder, name, "dataset.json")
    path.write_text(json.dumps({**json.loads(path.read_text(encoding="utf-8")), "truth": truth}), encoding="utf-8")


def report(folder, *arguments, out="page"):
    """Writes a page and returns its path."""
    fransac(folder, "report", *arguments, "--out", out, "--repeat", "1")
    return pathlib.Path(folder, out, "index.html")
