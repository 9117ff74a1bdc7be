# SPDX-License-Identifier: Apache-2.0
"""Results of the benchmark: reading, the few statistics that the page shows, and the compact form that is committed.

`bench_peers` writes every repetition of every frame. A `Row` is what is kept of one frame and one peer, a `Summary` what
is kept of a whole dataset:

- row: smallest, median and 99th percentile of the frame's repetitions (nearest rank, as in `fransac bench`);
- summary: of each of these the median over the dataset's frames, and the mean of precision, recall and F1.
"""

from __future__ import annotations

import dataclasses
import json
import math
import pathlib
from collections.abc import Callable, Iterable
from typing import Any

# Datasets with more scenes are shown by their means only.
FEW_SCENES = 12


def quantile(values: Iterable[float], share: float) -> float:
    """The smallest value that at least `share` of the values do not exceed (nearest rank)."""
    ordered = sorted(values)
    if not ordered:
        raise ValueError("quantile of no values")
    return ordered[min(max(math.ceil(share * len(ordered)), 1), len(ordered)) - 1]


def median(values: Iterable[float]) -> float:
    return quantile(values, 0.5)


def mean(values: Iterable[float]) -> float:
    listed = list(values)
    return math.fsum(listed) / len(listed)


@dataclasses.dataclass(frozen=True)
class Time:
    """Milliseconds."""

    min: float
    median: float
    p99: float

    @staticmethod
    def of(times_ms: list[float]) -> Time:
        return Time(min(times_ms), median(times_ms), quantile(times_ms, 0.99))


@dataclasses.dataclass(frozen=True)
class Row:
    """One peer on one frame. `time` is None when it was not timed; `note` says why."""

    suite: str
    peer: str
    library: str
    build: str
    method: str
    dataset: str
    scene: str
    width: int
    height: int
    points: int
    threads: int
    repeats: int
    time: Time | None
    stages_ms: dict[str, float]
    precision: float | None
    recall: float | None
    f1: float | None
    best_f1: float | None
    leaves: int | None
    note: str
    # Of frames whose truth holds every plane; the last four of those who return every plane.
    matched_f1: float | None = None
    instance_f1_50: float | None = None
    instance_f1_75: float | None = None
    weighted_iou: float | None = None
    plane_pixel_f1: float | None = None
    # Of frames whose objects are known, of those who find objects; where there is none, the last alone.
    object_f1_50: float | None = None
    object_f1_75: float | None = None
    over_segmentation: float | None = None
    under_segmentation: float | None = None
    false_objects: int | None = None

    @property
    def frame(self) -> tuple[str, str, int, int, int]:
        """What two rows share that were given the same input."""
        return (self.dataset, self.scene, self.width, self.height, self.points)


@dataclasses.dataclass(frozen=True)
class Summary:
    """One peer on a whole dataset. Times are over the `timed` ones of its `frames`, accuracy over all with truth."""

    rows: tuple[Row, ...]
    frames: int
    timed: int
    time: Time | None
    stages_ms: dict[str, float]
    precision: float | None
    recall: float | None
    f1: float | None
    best_f1: float | None

    @property
    def first(self) -> Row:
        return self.rows[0]

    @property
    def fps(self) -> float | None:
        return 1000.0 / self.time.median if self.time else None

    @property
    def runs(self) -> int:
        """Of a typical frame."""
        return int(median(row.repeats for row in self.rows if row.time)) if self.time else 0

    @property
    def notes(self) -> list[str]:
        """Why frames were not timed."""
        return sorted({row.note for row in self.rows if row.note and not row.time})


def summarise(rows: Iterable[Row]) -> Summary:
    listed = tuple(rows)
    timed = [row for row in listed if row.time]
    stages = {name: median(row.stages_ms[name] for row in timed) for name in (timed[0].stages_ms if timed else {})}
    time = None
    if timed:
        time = Time(*(median(getattr(row.time, name) for row in timed) for name in ("min", "median", "p99")))

    def accuracy(of: Callable[[Row], float | None]) -> float | None:
        values = [value for row in listed if (value := of(row)) is not None]
        return mean(values) if values else None

    return Summary(
        listed,
        len(listed),
        len(timed),
        time,
        stages,
        accuracy(lambda row: row.precision),
        accuracy(lambda row: row.recall),
        accuracy(lambda row: row.f1),
        accuracy(lambda row: row.best_f1),
    )


def scores(rows: Iterable[Row], figure: str) -> list[float]:
    """A figure of accuracy of the frames that have it."""
    return [value for row in rows if (value := getattr(row, figure)) is not None]


def complete_scores(found: dict[str, Summary], figure: str) -> dict[str, list[float]]:
    """A figure of all who have it of as many frames as anybody: who was too slow for some has no mean to compare."""
    values = {peer: scores(summary.rows, figure) for peer, summary in found.items()}
    most = max(map(len, values.values()), default=0)
    return {peer: of_peer for peer, of_peer in values.items() if of_peer and len(of_peer) == most}


def ratio(slow: Iterable[Row], fast: Iterable[Row]) -> float | None:
    """How many times longer the first takes: the quotient of the medians over the frames that both were timed on."""
    first = {row.frame: row.time.median for row in slow if row.time}
    second = {row.frame: row.time.median for row in fast if row.time}
    common = first.keys() & second.keys()
    if not common:
        return None
    return median(first[frame] for frame in common) / median(second[frame] for frame in common)


@dataclasses.dataclass(frozen=True)
class Results:
    machine: dict[str, Any]
    command: str
    rows: tuple[Row, ...]
    # Accuracy of the four methods over settings and seeds; accuracy.py says how it is made.
    accuracy: list[dict[str, Any]]

    def select(self, **wanted: Any) -> list[Row]:
        return [row for row in self.rows if all(getattr(row, name) == value for name, value in wanted.items())]

    def datasets(self, suite: str) -> list[str]:
        return list(dict.fromkeys(row.dataset for row in self.rows if row.suite == suite))

    def summaries(self, **wanted: Any) -> dict[str, Summary]:
        """By peer, in the order of the program."""
        groups: dict[str, list[Row]] = {}
        for row in self.select(**wanted):
            groups.setdefault(row.peer, []).append(row)
        return {peer: summarise(rows) for peer, rows in groups.items()}


FIELDS = [field.name for field in dataclasses.fields(Row)]
OBJECT_SCORES = ("object_f1_50", "object_f1_75", "over_segmentation", "under_segmentation", "false_objects")
SCORES = ("matched_f1", "instance_f1_50", "instance_f1_75", "weighted_iou", "plane_pixel_f1", *OBJECT_SCORES)


def _row(raw: dict[str, Any]) -> Row:
    times = raw.get("times_ms") or []
    return Row(
        suite=raw["suite"],
        peer=raw["peer"],
        library=raw["library"],
        build=raw["build"],
        method=raw["method"],
        dataset=raw.get("dataset") or "",
        scene=raw.get("scene") or "",
        width=raw.get("width") or 0,
        height=raw.get("height") or 0,
        points=raw.get("points") or 0,
        threads=raw.get("threads") or 1,
        repeats=len(times),
        time=Time.of(times) if times else None,
        stages_ms=raw.get("stages_ms") or {},
        precision=raw.get("precision"),
        recall=raw.get("recall"),
        f1=raw.get("f1"),
        best_f1=raw.get("best_f1"),
        leaves=raw.get("leaves"),
        note=raw.get("note") or "",
        **{name: raw.get(name) for name in SCORES},
    )


def _compact_row(columns: list[str], cells: list[Any]) -> Row:
    named = dict(zip(columns, cells))
    return Row(**(named | {"time": Time(*named["time"]) if named["time"] else None}))


def load(path: pathlib.Path, accuracy: pathlib.Path | None = None) -> Results:
    """From bench_peers' own JSON or the compact form."""
    text = json.loads(path.read_text(encoding="utf-8"))
    if "columns" in text:
        # What is measured today and was not then is missing.
        if not set(FIELDS) - set(SCORES) <= set(text["columns"]) <= set(FIELDS):
            raise ValueError(f"{path}: its columns are of another version: {text['columns']}")
        rows = tuple(_compact_row(text["columns"], cells) for cells in text["rows"])
    else:
        rows = tuple(_row(raw) for raw in text["rows"])
    settings = json.loads(accuracy.read_text(encoding="utf-8")) if accuracy else text.get("accuracy", [])
    return Results(text["machine"], text["command"], rows, settings)


def _rounded(value: Any) -> Any:
    """Five significant digits: finer than the noise of any clock here."""
    if isinstance(value, float):
        return float(f"{value:.5g}")
    if isinstance(value, dict):
        return {key: _rounded(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_rounded(item) for item in value]
    return value


def compact(results: Results) -> Results:
    """As `save` writes and `load` reads it, so that page and committed figures agree to the last digit."""
    rows = [_compact_row(FIELDS, _rounded(_cells(row))) for row in results.rows]
    return dataclasses.replace(results, rows=tuple(rows), accuracy=_rounded(results.accuracy))


def _cells(row: Row) -> list[Any]:
    return [dataclasses.astuple(row.time) if name == "time" and row.time else getattr(row, name) for name in FIELDS]


def save(results: Results, path: pathlib.Path) -> None:
    """The compact form, a line per row so that two versions can be compared line by line."""

    def lines(items: Iterable[Any]) -> str:
        return ",\n".join(json.dumps(_rounded(item), separators=(",", ":")) for item in items)

    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(
        f'{{"machine": {json.dumps(results.machine, indent=1)},\n"command": {json.dumps(results.command)},\n'
        f'"columns": {json.dumps(FIELDS)},\n"rows": [\n{lines(_cells(row) for row in results.rows)}\n],\n'
        f'"accuracy": [\n{lines(results.accuracy)}\n]}}\n',
        encoding="utf-8",
    )
