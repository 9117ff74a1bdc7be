# SPDX-License-Identifier: Apache-2.0
"""Accuracy of the paper's four methods over settings and seeds, from `fransac evaluate`.

One random search says little about a method, so each setting runs with every seed of SEEDS. What is kept per setting,
dataset, scene and method: the mean over seeds, and as `*_sd` the standard deviation over seeds. The scene "mean", which is
all that is kept of datasets with many scenes, has the means over scenes of both.
"""

from __future__ import annotations

import collections
import json
import pathlib
import statistics
import subprocess
from typing import Any

from results import FEW_SCENES

METHODS = ("ransac", "rransac", "voxel-ransac", "fransac")
TEXTBOOK = ("--scoring", "inliers", "--no-local-optimisation", "--no-refine")
PAPER = (*TEXTBOOK, "--labels-from", "leaves")
SETTINGS: dict[str, tuple[str, ...]] = {
    "paper": PAPER,
    "textbook": TEXTBOOK,
    "leaves": ("--labels-from", "leaves"),
    "default": (),
    "paper-several": (*PAPER, "--planes", "all"),
    "several": ("--planes", "all"),
}
SEEDS = 20
FIGURES = ("precision", "recall", "f1", "best_f1")


def command(program: str, setting: str, seed: int | str, datasets: list[str]) -> list[str]:
    return [
        program,
        "evaluate",
        *datasets,
        "--method",
        ",".join(METHODS),
        *SETTINGS[setting],
        "--seed",
        str(seed),
        "--repeat",
        "1",
    ]


def measure(program: pathlib.Path, datasets: list[pathlib.Path], seeds: int = SEEDS) -> list[dict[str, Any]]:
    table = []
    for setting in SETTINGS:
        runs = []
        for seed in range(seeds):
            line = command(str(program), setting, seed, [str(dataset) for dataset in datasets])
            printed = subprocess.run([*line, "--json", "-"], check=True, stdout=subprocess.PIPE, text=True).stdout
            runs.append(json.loads(printed)["scenes"])
        table += aggregate(setting, runs)
    return table


def aggregate(setting: str, runs: list[list[dict[str, Any]]]) -> list[dict[str, Any]]:
    """`runs` holds what `fransac evaluate` said of every scene, once per seed. A figure that a scene lacks is left out."""
    found: dict[tuple[str, str, str], list[dict[str, Any]]] = {}
    for run in runs:
        for said in run:
            found.setdefault((pathlib.PurePath(said["dataset"]).name, said["scene"], said["method"]), []).append(said)

    rows = []
    for (dataset, scene, method), seeds in found.items():
        row: dict[str, Any] = {"setting": setting, "dataset": dataset, "scene": scene, "method": method, "seeds": len(seeds)}
        for figure in FIGURES:
            values = [one[figure] for one in seeds if one.get(figure) is not None]
            if values:
                row |= {figure: statistics.fmean(values), f"{figure}_sd": statistics.pstdev(values)}
        rows.append(row)

    means = []
    for dataset, method in dict.fromkeys((row["dataset"], row["method"]) for row in rows):
        scenes = find(rows, dataset=dataset, method=method)
        average: dict[str, Any] = {
            "setting": setting,
            "dataset": dataset,
            "scene": "mean",
            "method": method,
            "seeds": scenes[0]["seeds"],
        }
        for name in (name for figure in FIGURES for name in (figure, f"{figure}_sd")):
            values = [row[name] for row in scenes if name in row]
            if values:
                average[name] = statistics.fmean(values)
        means.append(average)
    scenes_of = collections.Counter((row["dataset"], row["method"]) for row in rows)
    return [row for row in rows if scenes_of[row["dataset"], row["method"]] <= FEW_SCENES] + means


def find(table: list[dict[str, Any]], **wanted: Any) -> list[dict[str, Any]]:
    return [row for row in table if all(row[name] == value for name, value in wanted.items())]
