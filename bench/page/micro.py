# SPDX-License-Identifier: Apache-2.0
"""The micro-benchmarks as rows of the results: suites `kernels`, `decoding` and `executors`."""

from __future__ import annotations

import json
import pathlib
from typing import Any

TO_MS = {"ns": 1e-6, "us": 1e-3, "ms": 1.0}


def _row(suite: str, peer: str, points: int, threads: int, times_ms: list[float]) -> dict[str, Any]:
    return {
        "suite": suite,
        "peer": peer,
        "library": "fransac",
        "build": "project",
        "method": suite,
        "points": points,
        "threads": threads,
        "times_ms": times_ms,
    }


def rows(reports: list[pathlib.Path]) -> list[dict[str, Any]]:
    """From what programs of Google Benchmark wrote: NAME, NAME_ref, NAME/POINTS or EXECUTOR/POINTS/THREADS/real_time."""
    found: dict[tuple[str, str, int, int], list[float]] = {}
    for report in reports:
        for run in json.loads(report.read_text(encoding="utf-8"))["benchmarks"]:
            if run.get("run_type") == "aggregate":
                continue
            name, *arguments = run["run_name"].removesuffix("/real_time").split("/")
            suite = "executors" if len(arguments) == 2 else "decoding" if name.startswith("png_") else "kernels"
            points = int(arguments[0]) if arguments else 0
            threads = int(arguments[1]) if len(arguments) == 2 else 1
            found.setdefault((suite, name, points, threads), []).append(run["real_time"] * TO_MS[run["time_unit"]])
    return [_row(suite, peer, points, threads, times) for (suite, peer, points, threads), times in found.items()]
