# SPDX-License-Identifier: Apache-2.0
"""Fills the blocks of docs/benchmark.md, docs/reproduction.md and README.md: the prose is written by hand, every figure comes from here.

A block is what stands between `<!-- block: NAME -->` and `<!-- end -->`; NAME is one of BLOCKS, or `plot NAME` with one
of PLOTS.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Container, Iterable, Sequence

import accuracy
import bars
from results import FEW_SCENES, OBJECT_SCORES, Results, Row, Summary, complete_scores, mean, ratio, scores, summarise

NOT_MEASURED = "*Not measured in this run.*"
BLOCK = re.compile(r"(<!-- block: (?P<name>[^>]+?) -->\n).*?(<!-- end -->)", re.DOTALL)

# What the paper's abstract and conclusion state: means over its scenes. The only figures of the paper used here.
PAPER = {
    ("fps", "fransac"): "39.5",
    ("f1", "fransac"): "0.870",
    ("recall", "fransac"): "0.775",
    ("f1", "ransac"): "0.946",
    ("speed-up", "fransac"): "7",
}
METHODS = accuracy.METHODS
OURS = (*METHODS, "cells")

# Programs that no distribution packages, on the same frames and with the same scorer, but measured elsewhere: time, instance F1
# at IoU 0.5 and 0.75, area-weighted IoU, matched F1, F1 of plane pixels.
QUOTED = {
    "tum": (
        ("CAPE", "1.2–1.3", "0.69", "0.57", "0.80", "0.95", "–"),
        ("PEAC", "8.7–10.8", "0.70", "0.64", "0.88", "0.93", "0.95"),
        ("a second annotator", "–", "0.94", "0.92", "0.92", "0.97", "0.96"),
    ),
    "icl_nuim": (("CAPE", "–", "0.86", "–", "–", "–", "–"),),
}
SETTING_NAMES = {
    "paper": "the paper's",
    "textbook": "the same, labels from pixels",
    "leaves": "our defaults, labels from leaves",
    "default": "our defaults",
}


def table(head: Sequence[str], lines: Iterable[Sequence[str]], left: int = 1) -> str:
    """A Markdown table; the first `left` columns are words, the others numbers."""
    rule = ["---" if place < left else "---:" for place in range(len(head))]
    return "\n".join("| " + " | ".join(cells) + " |" for cells in [head, rule, *lines])


def number(value: float | None, digits: int = 3, unit: str = "") -> str:
    return "–" if value is None else f"{value:.{digits}f}{unit}"


def significant(value: float | None, unit: str = "") -> str:
    """Three significant digits without an exponent; four and more digits in groups."""
    if value is None:
        return "–"
    if value >= 1000:
        return f"{float(f'{value:.3g}'):,.0f}{unit}"
    text = f"{value:#.3g}"
    return text.rstrip(".") + unit


def ms(value: float | None) -> str:
    return significant(value)


def machine(results: Results) -> str:
    about = results.machine
    lines = [
        ("machine", f"{about.get('cpu', '?')}, {about.get('cores', '?')} cores, {about.get('kernel', '?')}"),
        ("compiler", f"{about.get('compiler', '?')}, {about.get('build_type', '?')}"),
        ('"native"', f"`{about.get('flags_native', '?')}`; ours and \"packaged\": the distribution's baseline, no `-march`"),
        ("libraries", ", ".join(f"{name} {version}" for name, version in about.get("libraries", {}).items())),
        ("commit, date", f"{about.get('commit') or '?'}, {about.get('date') or '?'}"),
        ("command", f"`{results.command}`"),
    ]
    return table(("", ""), lines, left=2)


def claims(results: Results) -> str:
    lines = []
    for claim in bars.claims(results):
        digits = 4 if not claim.unit else 3 if claim.unit == " ms" else 1 if claim.limit >= 2 else 2
        limit_digits = 4 if not claim.unit else 2 if claim.unit == " ms" else 1
        measured = number(claim.measured, digits, claim.unit)
        lines.append(
            (
                claim.what,
                claim.where,
                f"{claim.relation} {claim.limit:.{limit_digits}f}{claim.unit}",
                measured,
                f"**{claim.verdict}**" if claim.met is False else claim.verdict,
            )
        )
    return table(("what", "on", "bar", "measured", ""), lines, left=2)


def _floor(results: Results, dataset: str) -> list[Row]:
    return results.select(suite="floor", peer="floor-deproject", dataset=dataset)


def readme(results: Results) -> str:
    """Every plane of the TUM frames, shortly."""
    found = results.summaries(suite="planes", dataset="tum", threads=1)
    names = {
        "cells": "**`cells`**",
        "opencv-rgbdplane": "OpenCV `RgbdPlane`",
        "pcl-organized-native": "PCL `OrganizedMultiPlaneSegmentation`",
    }
    lines = []
    for peer, name in names.items():
        if peer not in found:
            continue
        rows = found[peer].rows
        times = [row.time.median for row in rows if row.time]
        values = [scores(rows, figure) for figure in ("instance_f1_50", "instance_f1_75", "weighted_iou", "matched_f1")]
        lines.append([name, ms(mean(times) if times else None), *(number(mean(each) if each else None, 2) for each in values)])
    if not lines:
        return NOT_MEASURED
    lines += [[f"*{name}*", *cells[:5]] for name, *cells in QUOTED["tum"]]
    return table(("", "ms a frame", "F1 at IoU 0.5", "at 0.75", "weighted IoU", "first plane"), lines)


def all_planes(results: Results) -> str:
    """Those that return every plane, by dataset."""
    parts = []
    for dataset in (name for name in results.datasets("planes") if name):
        found = results.summaries(suite="planes", dataset=dataset, threads=1)
        floor = results.select(suite="planes", peer="floor-deproject", dataset=dataset)
        figures = ("instance_f1_50", "instance_f1_75", "weighted_iou", "matched_f1", "plane_pixel_f1")
        lines = []
        for peer, summary in found.items():
            if summary.first.library == "floor":
                continue
            times = [row.time.median for row in summary.rows if row.time]
            accuracy_of = [scores(summary.rows, figure) for figure in figures]
            dominant = scores(summary.rows, "f1") if not accuracy_of[0] else []
            lines.append(
                [
                    f"**{peer}**" if summary.first.library == "fransac" else peer,
                    _build(summary),
                    *(ms(value) for value in ((mean(times), max(times)) if times else (None, None))),
                    significant(ratio(summary.rows, floor)),
                    *(number(mean(values) if values else None) for values in accuracy_of),
                    number(min(accuracy_of[3], default=None)),
                    number(mean(dominant) if dominant else None, 4),
                    number(min(dominant, default=None), 4),
                ]
            )
        for name, time, *quoted in QUOTED.get(dataset, ()):
            lines.append([f"*{name}*", "*quoted*", time, "–", "–", *quoted, "–", "–", "–"])
        head = [
            "", "build", "mean frame", "worst", "× floor", "F1 at 0.5", "at 0.75", "weighted IoU", "matched F1", "plane pixels",
            "worst matched", "dominant F1", "worst",
        ]  # fmt: skip
        kept = [place for place in range(len(head)) if place < 4 or any(line[place] != "–" for line in lines)]
        frames = len({row.scene for row in results.select(suite="planes", dataset=dataset)})
        title = f"**{dataset}**, {frames} frame{'' if frames == 1 else 's'}, milliseconds"
        parts.append(
            f"{title}\n\n" + table([head[i] for i in kept], ([line[i] for i in kept] for line in lines), left=2)
        )
    return "\n\n".join(parts) or NOT_MEASURED


def objects(results: Results) -> str:
    """Those that find objects, by dataset."""
    parts = []
    for dataset in (name for name in results.datasets("objects") if name):
        found = results.summaries(suite="objects", dataset=dataset, threads=1)
        floor = results.select(suite="objects", peer="floor-deproject", dataset=dataset)
        *shares, false = (complete_scores(found, figure) for figure in OBJECT_SCORES)
        lines = []
        for peer, summary in found.items():
            if summary.first.library == "floor":
                continue
            lines.append(
                [
                    f"**{peer}**" if summary.first.library == "fransac" else peer,
                    _build(summary),
                    _frames(summary),
                    ms(summary.time.median if summary.time else None),
                    significant(ratio(summary.rows, floor)),
                    *(number(mean(of[peer]) if peer in of else None) for of in shares),
                    number(sum(false[peer]) if peer in false else None, 0),
                ]
            )
        head = ("", "build", "frames", "median", "× floor", "F1 at 0.5", "at 0.75", "over", "under", "false objects")
        text = [f"**{dataset}**, milliseconds", "", table(head, lines, left=2), "", *_notes(results, "objects", found)]
        parts.append("\n".join(text).rstrip())
    return "\n\n".join(parts) or NOT_MEASURED


def _build(summary: Summary) -> str:
    return {"project": "ours", "floor": "floor"}.get(summary.first.build, summary.first.build)


def _frames(summary: Summary) -> str:
    return str(summary.timed) if summary.timed == summary.frames else f"{summary.timed} of {summary.frames}"


def _times(summary: Summary) -> list[str]:
    time = summary.time
    if not time:
        return ["–"] * 3
    return [ms(time.min), ms(time.median), ms(time.p99)]


def _faster(value: float, peer: str) -> str:
    """`value`: how many times longer the other one takes."""
    return f"{significant(value)}× faster than {peer}" if value >= 1.0 else f"{significant(1.0 / value)}× slower than {peer}"


def _against(summary: Summary, found: dict[str, Summary]) -> str:
    """Ours: against the best rival of the same method. Rivals: against ours of the same method."""
    row = summary.first
    if row.library == "floor":
        return ""
    ours = row.library == "fransac"
    others = [
        (value, peer)
        for peer, other in found.items()
        if other.first.method == row.method
        and (other.first.library == "fransac") != ours
        and (value := ratio(other.rows, summary.rows)) is not None
    ]
    if not others:
        return ""
    text = _faster(*min(others))
    return f"**{text}**" if ours else text


def _listed(notes: list[str]) -> str:
    return "; ".join(notes[:2]) + (f"; and {len(notes) - 2} more like these" if len(notes) > 2 else "")


def _notes(results: Results, suite: str, found: dict[str, Summary]) -> list[str]:
    """Why some of `found`, or those who were not built, were not timed."""
    missing = {peer: summary for peer, summary in results.summaries(suite=suite, dataset="").items() if peer not in found}
    return [f"- {peer}: {_listed(summary.notes)}." for peer, summary in (found | missing).items() if summary.notes]


def _everybody(results: Results, suite: str, dataset: str) -> str:
    found = results.summaries(suite=suite, dataset=dataset, threads=1)
    has_truth = any(summary.f1 is not None for summary in found.values())
    floor = _floor(results, dataset)
    lines = []
    for peer, summary in found.items():
        name = f"**{peer}**" if summary.first.library == "fransac" else peer
        cells = [
            name,
            _build(summary),
            _frames(summary),
            str(summary.runs),
            *_times(summary),
            significant(summary.fps),
            significant(ratio(summary.rows, floor)),
            _against(summary, found),
        ]
        if has_truth:
            cells += [number(summary.precision), number(summary.recall), number(summary.f1, 4), number(summary.best_f1, 4)]
        lines.append(cells)
    head = ["", "build", "frames", "runs", "min", "median", "p99", "fps", "× floor", "same method"]
    text = table(head + (["precision", "recall", "F1", "best F1"] if has_truth else []), lines, left=2)
    return "\n".join([text, "", *_notes(results, suite, found)]).rstrip()


def _per_dataset(suite: str) -> Callable[[Results], str]:
    def block(results: Results) -> str:
        parts = [
            f"**{dataset}**, milliseconds\n\n{_everybody(results, suite, dataset)}"
            for dataset in results.datasets(suite)
            if dataset
        ]
        return "\n\n".join(parts) or NOT_MEASURED

    return block


def same_method(results: Results) -> str:
    """Ours against PCL native, PCL packaged and the best of all."""
    lines = []
    for dataset in (name for name in results.datasets("segment") if name):
        found = results.summaries(suite="segment", dataset=dataset, threads=1)
        for method in METHODS[::-1]:
            own = found.get(method)
            if own is None or not own.time:
                continue
            cells = [method, dataset, ms(own.time.median), number(own.f1, 4)]
            for peer in (f"pcl-{method}-native", f"pcl-{method}-packaged"):
                rival = found.get(peer)
                value = ratio(rival.rows, own.rows) if rival else None
                cells += [
                    ms(rival.time.median if rival and rival.time else None),
                    significant(value, "×"),
                    number(rival.f1 if rival else None, 4),
                ]
            lines.append(cells)
    head = ("method", "on", "ours [ms]", "F1", "PCL native [ms]", "ours faster", "F1", "PCL packaged [ms]", "ours faster", "F1")
    return table(head, lines, left=2) if lines else NOT_MEASURED


def stages(results: Results) -> str:
    names = ["deproject", "pass_through", "voxel_grid", "ransac", "cells", "regions", "merge", "labels"]
    lines = []
    for dataset in results.datasets("segment"):
        for peer, summary in results.summaries(suite="segment", dataset=dataset, library="fransac", threads=1).items():
            if summary.stages_ms:
                lines.append([peer, dataset, *(significant(summary.stages_ms.get(name) or None) for name in names)])
    return table(("method", "on", *(name.replace("_", " ") for name in names)), lines, left=2) if lines else NOT_MEASURED


def fps_by_scene(results: Results) -> str:
    """The paper's figure 4 in numbers."""
    lines = []
    for dataset in (name for name in results.datasets("segment") if name):
        scenes = list(dict.fromkeys(row.scene for row in results.select(suite="segment", dataset=dataset)))
        for scene in scenes if len(scenes) <= FEW_SCENES else []:
            found = results.summaries(suite="segment", dataset=dataset, scene=scene, library="fransac", threads=1)
            lines.append([dataset, scene, *(significant(found[method].fps if method in found else None) for method in OURS)])
        found = results.summaries(suite="segment", dataset=dataset, library="fransac", threads=1)
        lines.append([dataset, "median", *(significant(found[method].fps if method in found else None) for method in OURS)])
    if not lines:
        return NOT_MEASURED
    lines.append(["the paper's mean", "", *(PAPER.get(("fps", method), "–") for method in OURS)])
    return table(("", "scene", *OURS), lines, left=2)


def threads(results: Results) -> str:
    rows = results.select(suite="threads")
    lines = []
    for peer in dict.fromkeys(row.peer for row in rows):
        for scene in dict.fromkeys(row.scene for row in rows):
            own = [row for row in rows if row.peer == peer and row.scene == scene]
            one = [row for row in own if row.threads == 1]
            two = [row for row in own if row.threads == 2]
            if one and two:
                times = [summarise(rows).time for rows in (one, two)]
                if not any(times):
                    continue  # not for this input
                size = f"{one[0].width}×{one[0].height} pixels" if one[0].height > 1 else f"{one[0].points:,} points"
                size += f", {one[0].dataset}" if one[0].dataset == bars.LARGE else ""
                lines.append(
                    [peer, size, *(ms(time.median if time else None) for time in times), number(ratio(one, two), 2, "×")]
                )
    return table(("", "input", "1 thread [ms]", "2 threads [ms]", "speed-up"), lines, left=2) if lines else NOT_MEASURED


def _us(row: Row | None) -> str:
    return significant(row.time.median * 1e3 if row and row.time else None)


def kernels(results: Results) -> str:
    """Each kernel beside its scalar truth."""
    found = {(row.peer, row.points): row for row in results.select(suite="kernels")}
    lines = []
    for (name, points), vector in found.items():
        if name.endswith("_ref"):
            continue
        scalar = found.get((name + "_ref", points))
        quotient = scalar.time.median / vector.time.median if scalar and scalar.time and vector.time else None
        size = f"{points:,} points" if points else "640×480 pixels"
        lines.append([f"`{name}`", size, _us(vector), _us(scalar), number(quotient, 1, "×")])
    return table(("kernel", "input", "vectors [µs]", "scalar truth [µs]", ""), lines, left=2) if lines else NOT_MEASURED


def decoding(results: Results) -> str:
    """A depth PNG by the project's decoder and by libspng, for each filter."""
    found = {row.peer: row for row in results.select(suite="decoding")}
    lines = []
    for name, ours in found.items():
        if name.endswith("_ref"):
            continue
        spng = found.get(name + "_ref")
        quotient = spng.time.median / ours.time.median if spng and spng.time and ours.time else None
        lines.append([name.removeprefix("png_"), _us(ours), _us(spng), number(quotient, 1, "×")])
    return table(("filter", "fransac [µs]", "libspng [µs]", ""), lines, left=1) if lines else NOT_MEASURED


def executors(results: Results) -> str:
    found = {(row.peer, row.points, row.threads): row for row in results.select(suite="executors")}
    lines = []
    for name, points in dict.fromkeys((name, points) for name, points, _ in found):
        one, two = (found.get((name, points, threads)) for threads in (1, 2))
        quotient = one.time.median / two.time.median if one and two and one.time and two.time else None
        lines.append([name.replace("_", " "), f"{points:,} points", _us(one), _us(two), number(quotient, 2, "×")])
    return table(("executor", "input", "1 thread [µs]", "2 threads [µs]", "speed-up"), lines, left=2) if lines else NOT_MEASURED


def _paper_table(figure: str) -> Callable[[Results], str]:
    """Like the paper's tables 4 to 6: scenes of tum by methods in the paper's setting, mean ± standard deviation over seeds."""

    def block(results: Results) -> str:
        rows = accuracy.find(results.accuracy, setting="paper", dataset="tum")
        if not rows:
            return NOT_MEASURED
        cells = {(row["scene"], row["method"]): f"{row[figure]:.3f} ± {row[figure + '_sd']:.3f}" for row in rows}
        mosd = {
            row["method"]: f"{row[figure]:.3f} ± {row[figure + '_sd']:.3f}"
            for row in accuracy.find(results.accuracy, setting="paper", dataset="mosd", scene="mean")
        }
        lines = [
            [f"tum {scene}", *(cells.get((scene, method), "–") for method in METHODS)]
            for scene in dict.fromkeys(row["scene"] for row in rows)
        ]
        if mosd:
            lines.append(["mosd mean", *(mosd.get(method, "–") for method in METHODS)])
        lines.append(["the paper's mean", *(PAPER.get((figure, method), "–") for method in METHODS)])
        return table(("", *METHODS), lines)

    return block


def settings(results: Results) -> str:
    lines = []
    for dataset in dict.fromkeys(row["dataset"] for row in results.accuracy):
        for setting, name in SETTING_NAMES.items():
            for row in accuracy.find(results.accuracy, setting=setting, dataset=dataset, scene="mean"):
                lines.append(
                    [
                        dataset,
                        name,
                        row["method"],
                        *(number(row[figure]) for figure in ("precision", "recall", "f1", "precision_sd")),
                    ]
                )
    return (
        table(("", "setting", "method", "precision", "recall", "F1", "precision varies by"), lines, left=3)
        if lines
        else NOT_MEASURED
    )


def several(results: Results) -> str:
    """All planes asked for: F1 of the one that overlaps the truth most, in the paper's setting and in ours."""
    cells = {}
    for setting in ("paper-several", "several"):
        for row in accuracy.find(results.accuracy, setting=setting, dataset="tum"):
            cells[row["scene"], setting, row["method"]] = number(row.get("best_f1"))
    if not cells:
        return NOT_MEASURED
    columns = [(setting, method) for setting in ("paper-several", "several") for method in METHODS]
    lines = [
        [f"tum {scene}", *(cells.get((scene, *column), "–") for column in columns)]
        for scene in dict.fromkeys(key[0] for key in cells)
    ]
    lines.append(
        [
            "the paper's mean",
            *(PAPER.get(("f1", method), "–") if setting == "paper-several" else "" for setting, method in columns),
        ]
    )
    return table(("", *(method + (", our defaults" if setting == "several" else "") for setting, method in columns)), lines)


def speed_up(results: Results) -> str:
    """How much faster than RANSAC the other methods are: ours, and made of PCL's parts."""
    lines = []
    for dataset in (name for name in results.datasets("segment") if name):
        found = results.summaries(suite="segment", dataset=dataset, threads=1)
        for name, pattern in (("ours", "{}"), ("PCL, native", "pcl-{}-native"), ("PCL, packaged", "pcl-{}-packaged")):
            base = found.get(pattern.format("ransac"))
            others = [found.get(pattern.format(method)) for method in METHODS]
            if base is None or not base.time:
                continue
            lines.append(
                [
                    dataset,
                    name,
                    *(significant(other.fps if other else None) for other in others),
                    *(significant(ratio(base.rows, other.rows) if other else None, "×") for other in others[1:]),
                ]
            )
    if not lines:
        return NOT_MEASURED
    lines.append(
        [
            "the paper's",
            "",
            *(PAPER.get(("fps", method), "–") for method in METHODS),
            *(f"{PAPER[('speed-up', method)]}×" if ("speed-up", method) in PAPER else "–" for method in METHODS[1:]),
        ]
    )
    head = ("", "", *(f"{method} [fps]" for method in METHODS), *(f"{method} / ransac" for method in METHODS[1:]))
    return table(head, lines, left=2)


def evaluate_commands(results: Results) -> str:
    lines = ["```sh"]
    for setting in accuracy.SETTINGS:
        lines.append(
            " ".join(accuracy.command("fransac", setting, "SEED", ["../shared/data/tum", "../shared/data/mosd"]))
            + f"  # {setting}"
        )
    return "\n".join([*lines, "```"])


BLOCKS: dict[str, Callable[[Results], str]] = {
    "kernels": kernels,
    "decoding": decoding,
    "executors": executors,
    "machine": machine,
    "claims": claims,
    "readme": readme,
    "all planes": all_planes,
    "objects": objects,
    "segment": _per_dataset("segment"),
    "same method": same_method,
    "voxel grid": _per_dataset("voxel_grid"),
    "sac": _per_dataset("sac"),
    "floor": _per_dataset("floor"),
    "stages": stages,
    "fps by scene": fps_by_scene,
    "threads": threads,
    "paper precision": _paper_table("precision"),
    "paper recall": _paper_table("recall"),
    "paper f1": _paper_table("f1"),
    "settings": settings,
    "several": several,
    "speed-up": speed_up,
    "evaluate commands": evaluate_commands,
}


PLOTS = {
    "fps-by-scene": "Frames per second by scene and method",
    "accuracy-speed": "Accuracy against time, everybody",
    "stages": "Where the time goes, by stage",
    "resolution": "Time against resolution",
    "points": "Time against the number of points",
}


def plot(name: str, drawn: Container[str]) -> str:
    title = PLOTS[name]
    return f"![{title}](benchmark/{name}.svg)" if name in drawn else NOT_MEASURED


def fill(text: str, results: Results, drawn: Container[str]) -> str:
    """`text` with its blocks rewritten; `drawn` holds the names of the plots that there are. An unknown block is a KeyError."""

    def block(match: re.Match[str]) -> str:
        name = match["name"]
        content = plot(name.removeprefix("plot "), drawn) if name.startswith("plot ") else BLOCKS[name](results)
        return f"{match[1]}{content}\n{match[3]}"

    return BLOCK.sub(block, text)
