#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs the `fransac …` commands of a page as they stand there: page_test.py PAGE FRANSAC.

What they read (depth.png with its camera.json, scan.pcd, dataset) is rendered first: a desk. Runs and frames are cut down. What
the commands find must be right: planes and objects match the truth, files hold what the others of the same command say.
"""
import collections
import json
import math
import pathlib
import re
import shlex
import shutil
import subprocess
import sys
import tempfile

import inputs

WIDTH, HEIGHT = 160, 120
FRAMES = 2  # of what the page renders, and runs of what it times
NO_PLANE = 255
# What `cells` reaches on the rendered desk, and a wrong support or a wrong plane does not.
MIN_F1 = {"F1": 0.95, "F1@0.5": 0.7, "object F1@0.5": 0.6}


def commands(page):
    """The lines of shell blocks that start with fransac."""
    blocks = re.findall(r"```sh\n(.*?)```", page, re.S)
    return [line.strip() for block in blocks for line in block.splitlines() if line.startswith("fransac ")]


def documents(path):
    """The JSON documents of a file: one, or one a line."""
    text = path.read_text(encoding="utf-8")
    return [json.loads(line) for line in text.splitlines()] if path.suffix == ".jsonl" else [json.loads(text)]


def value_of(words, option):
    return words[words.index(option) + 1] if option in words else None


def check_planes(planes):
    assert planes, "no plane"
    for plane in planes:
        assert math.isclose(math.hypot(*plane["normal"]), 1.0, rel_tol=1e-6), plane
        assert plane["inliers"] > 0 and plane["area_m2"] > 0, plane


def check_obstacles(found, planes):
    """Things stand on the support, which is level."""
    assert found["support"], f"no support: {found['support_reason']}"
    assert planes[found["support"][0] - 1]["kind"] == found["support_kind"]
    assert found["support_kind"] in ("floor", "horizontal") and found["support_doubt"] is None, found
    objects = [thing for thing in found["objects"] if thing["kind"] != "drop"]
    assert any(thing["contact"] for thing in objects), "nothing stands on the support"


def check_segmentation(folder, words):
    names = {option: value_of(words, f"--{option}") for option in ("json", "labels", "obstacle-labels", "overlay", "cloud")}
    if names["overlay"]:
        header = (folder / names["overlay"]).read_bytes()
        assert header[:8] == inputs.PNG_SIGNATURE and int.from_bytes(header[16:20], "big") >= WIDTH
    if names["cloud"]:
        labels = collections.Counter(inputs.ply_column((folder / names["cloud"]).read_bytes(), "label"))
        assert labels[1] > labels[NO_PLANE], f"points by label: {labels}"
    if not names["json"]:
        return
    [found] = documents(folder / names["json"])
    if "--parallel-to" not in words:
        check_planes(found["planes"])
    assert all("outlines" in plane for plane in found["planes"]) == ("--outlines" in words)
    if names["labels"]:
        pixels = collections.Counter(inputs.grey((folder / names["labels"]).read_bytes(), 8))
        assert all(pixels[plane["id"]] == plane["inliers"] for plane in found["planes"]), pixels
    if "--obstacles" in words:
        check_obstacles(found["obstacles"], found["planes"])
    if names["obstacle-labels"]:
        pixels = collections.Counter(inputs.grey((folder / names["obstacle-labels"]).read_bytes(), 16))
        assert all(pixels[thing["id"]] == thing["pixels"] for thing in found["obstacles"]["objects"]), pixels


def check_tables(stdout, words):
    """Rows of planes are numbered, and a support is named."""
    if "obstacles" in " ".join(words):
        assert re.search(r"^support +kind +why", stdout, re.M) and not re.search(r"^none ", stdout, re.M), stdout
    if "--parallel-to" not in words:
        assert re.search(r"^ +1 +\([+-]\d", stdout, re.M), stdout


def check_evaluation(stdout, words):
    """The means of `cells` reach their bars."""
    lines = stdout.splitlines()
    headings = re.split(r"  +", lines[0].strip())
    means = [line for line in lines if re.match(r"mean +(auto|cells) ", line)]
    assert means, stdout
    row = dict(zip(headings, re.split(r"  +", means[0].strip())))
    assert ("object F1@0.5" in row) == ("--obstacles" in words), row
    for name, least in MIN_F1.items():
        assert name not in row or float(row[name]) >= least, f"{name} is {row[name]}"


def check_tracking(path):
    """A line for each frame, and planes that keep their ids."""
    lines = documents(path)
    assert len(lines) == FRAMES, f"{len(lines)} lines"
    ids = [{plane["id"] for plane in line["planes"]} for line in lines]
    assert all(ids) and set.intersection(*ids), f"no plane is in every frame: {ids}"


def check(folder, words, stdout):
    """Looks at what a command of the page has printed and written."""
    command = words[1]
    if command == "segment":
        check_segmentation(folder, words)
        if not any(option in words for option in ("--json", "--labels", "--overlay", "--cloud", "--obstacle-labels")):
            check_tables(stdout, words)
    elif command == "evaluate":
        check_evaluation(stdout, words)
    elif command == "track":
        check_tracking(folder / value_of(words, "--json"))
    elif command == "bench":
        times = [float(number) for number in re.findall(r"\d+\.\d+", stdout)]
        assert times and all(map(math.isfinite, times)), stdout
    elif command == "report":
        page = (folder / value_of(words, "--out") / "index.html").read_text(encoding="utf-8")
        assert "<table" in page and "<svg" in page, "a report without tables or plots"
    elif command == "synth":
        assert list((folder / words[2]).rglob("*.png")), f"{words[2]} has no frames"
    elif command == "calibrate":
        assert "noise" in (folder / value_of(words, "--out")).read_text(encoding="utf-8")


def main():
    page, fransac = (pathlib.Path(argument).resolve() for argument in sys.argv[1:])
    found = commands(page.read_text(encoding="utf-8"))
    assert len(found) >= 2, f"{page} holds only {found}"
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)

        def run(*arguments):
            done = subprocess.run([fransac, *arguments], cwd=folder, capture_output=True, text=True, check=False)
            assert done.returncode == 0, f"{arguments}: exit {done.returncode}: {done.stderr}"
            return done.stdout

        run("synth", "dataset", "--width", str(WIDTH), "--height", str(HEIGHT))
        frame = next(pathlib.Path(folder, "dataset").glob("*/depth.png")).parent
        for file in ("depth.png", "camera.json"):
            shutil.copy(frame / file, folder)
        run("segment", "depth.png", "--cloud", "scan.pcd")
        for command in found:
            words = shlex.split(re.sub(r"--(frames|repeat) \d+", rf"--\1 {FRAMES}", command), comments=True)
            stdout = run(*words[1:])
            try:
                check(folder, words, stdout)
            except (AssertionError, LookupError, ValueError, OSError) as error:
                sys.exit(f"{command}: {error!r}")
    print(f"{len(found)} commands work, and what they found is right")


main()
