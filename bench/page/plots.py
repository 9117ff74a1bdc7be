# SPDX-License-Identifier: Apache-2.0
"""The plots of docs/benchmark.md. Each takes the results and returns a figure, or None when the run holds nothing for it."""

from __future__ import annotations

import pathlib
from collections.abc import Callable, Sequence

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
from matplotlib.axes import Axes  # noqa: E402
from matplotlib.axis import Axis  # noqa: E402
from matplotlib.figure import Figure  # noqa: E402
from matplotlib.lines import Line2D  # noqa: E402
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter  # noqa: E402

from results import FEW_SCENES, Results, Row, Summary, median  # noqa: E402

# Okabe and Ito's palette, which colour-blind readers can tell apart.
ORANGE, SKY, GREEN, YELLOW, BLUE, VERMILION, PURPLE, GREY = (
    "#E69F00",
    "#56B4E9",
    "#009E73",
    "#F0E442",
    "#0072B2",
    "#D55E00",
    "#CC79A7",
    "#777777",
)
LIBRARY_COLOURS = {"fransac": VERMILION, "pcl": BLUE, "open3d": GREEN, "opencv": PURPLE, "cgal": ORANGE, "floor": GREY}
METHOD_COLOURS = {"cells": PURPLE, "fransac": VERMILION, "voxel-ransac": ORANGE, "rransac": GREEN, "ransac": BLUE}
METHOD_MARKERS = {"fransac": "*", "voxel-ransac": "D", "rransac": "^", "ransac": "o", "multi-plane": "s", "voxel-grid": "D"}
STAGE_COLOURS = {
    "deproject": GREY,
    "pass_through": YELLOW,
    "voxel_grid": SKY,
    "ransac": VERMILION,
    "cells": BLUE,
    "regions": ORANGE,
    "merge": PURPLE,
    "labels": GREEN,
}
LIBRARY_NAMES = {"fransac": "ours", "pcl": "PCL", "open3d": "Open3D", "opencv": "OpenCV", "cgal": "CGAL", "floor": "floor"}

STYLE = {
    "font.family": "DejaVu Sans",
    "font.size": 9,
    "axes.grid": True,
    "grid.color": "#dddddd",
    "grid.linewidth": 0.6,
    "axes.axisbelow": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "figure.facecolor": "white",
    "svg.fonttype": "none",
    "svg.hashsalt": "fransac",
    "legend.frameon": False,
}


def _filled(row: Row) -> bool:
    """Hollow markers are packaged builds."""
    return row.build != "packaged"


def _marker(row: Row) -> dict[str, object]:
    colour = LIBRARY_COLOURS[row.library]
    return {
        "marker": METHOD_MARKERS.get(row.method, "x"),
        "color": colour,
        "markerfacecolor": colour if _filled(row) else "white",
    }


def spread(heights: Sequence[float], gap: float) -> list[float]:
    """Moves ascending heights as little as brings them `gap` apart: those too close are laid out evenly around their mean."""
    groups: list[tuple[float, int]] = []  # sum of the heights, count
    for height in heights:
        groups.append((height, 1))
        while len(groups) > 1:
            (sum_below, below), (sum_above, above) = groups[-2:]
            if sum_above / above - sum_below / below >= gap * (below + above) / 2:
                break
            groups[-2:] = [(sum_below + sum_above, below + above)]
    return [total / count + gap * (place - (count - 1) / 2) for total, count in groups for place in range(count)]


def _label_ends(axes: Axes, ends: Sequence[tuple[float, float, str, str]]) -> None:
    """Writes (x, y, text, colour) right of each line's end, without overlaps. After the axes have their place and limits."""
    ends = sorted(ends, key=lambda end: end[1])
    heights = [axes.transData.transform((x, y))[1] * 72.0 / axes.figure.dpi for x, y, _, _ in ends]
    for (x, y, text, colour), height, placed in zip(ends, heights, spread(heights, 10.0)):
        axes.annotate(
            text,
            (x, y),
            xytext=(8, placed - height),
            textcoords="offset points",
            va="center",
            fontsize=8,
            color=colour,
            bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 0.5},
        )


def _plain_ticks(axis: Axis, low: float, high: float) -> None:
    """Powers of ten as plain numbers; 2 and 5 as well where there are few of them."""
    few = high / low < 300
    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if few else (1.0,)))
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:,.0f}" if value >= 1 else f"{value:g}"))
    axis.set_minor_formatter(NullFormatter())


def fps_by_scene(results: Results) -> Figure | None:
    """The paper's figure 4: each scene of tum; of the other datasets their medians."""
    datasets = results.datasets("segment")
    columns: list[tuple[str, dict[str, Summary]]] = []
    for dataset in (name for name in datasets if name):
        scenes = list(dict.fromkeys(row.scene for row in results.select(suite="segment", dataset=dataset)))
        if len(scenes) <= FEW_SCENES:
            columns += [
                (f"{dataset}\n{scene}", results.summaries(suite="segment", dataset=dataset, scene=scene)) for scene in scenes
            ]
        else:
            columns.append((f"{dataset}\n({len(scenes)} scenes)", results.summaries(suite="segment", dataset=dataset)))
    if not columns:
        return None
    figure, axes = plt.subplots(figsize=(8.2, 4.2))
    ends = []
    for method, colour in METHOD_COLOURS.items():
        for peer, style in (
            (method, {"linewidth": 1.8, "markersize": 6}),
            (f"pcl-{method}-native", {"linewidth": 1.0, "markersize": 4.5, "linestyle": "--", "markerfacecolor": "white"}),
        ):
            points = [(x, fps) for x, (_, found) in enumerate(columns) if peer in found and (fps := found[peer].fps)]
            if points:
                axes.plot(*zip(*points), marker="o", color=colour, **style)
                ends.append((*points[-1], peer.replace("pcl-", "PCL ").replace("-native", ""), colour))
    axes.set_yscale("log")
    axes.set_xlim(-0.3, len(columns) - 0.7)
    axes.set_xticks(range(len(columns)), [name for name, _ in columns], fontsize=8)
    axes.set_ylabel("frames per second")
    axes.set_title("Solid: ours. Dashed: the same method of natively compiled PCL parts. One thread.", loc="left", fontsize=9)
    figure.subplots_adjust(left=0.085, right=0.83, top=0.92, bottom=0.13)
    _plain_ticks(axes.yaxis, *axes.get_ylim())
    _label_ends(axes, ends)
    return figure


def accuracy_speed(results: Results) -> Figure | None:
    datasets = [name for name in results.datasets("segment") if name]
    if not datasets:
        return None
    figure, panels = plt.subplots(1, len(datasets), figsize=(4.3 * len(datasets) + 0.6, 4.6), squeeze=False)
    seen: list[Row] = []
    for axes, dataset in zip(panels[0], datasets):
        for peer, found in results.summaries(suite="segment", dataset=dataset, threads=1).items():
            row = found.first
            if not found.time or found.f1 is None:
                continue
            seen.append(row)
            size = 13 if row.library == "fransac" and row.method == "fransac" else 9 if row.library == "fransac" else 6.5
            axes.plot(
                found.time.median,
                found.f1,
                linestyle="none",
                markersize=size,
                zorder=3 if row.library == "fransac" else 2,
                **_marker(row),
            )
        axes.set_xscale("log")
        _plain_ticks(axes.xaxis, *axes.get_xlim())
        axes.set_xlabel("median time per frame [ms], one thread")
        axes.set_title(
            f"{dataset} ({len({row.scene for row in results.select(suite='segment', dataset=dataset)})} frames)",
            loc="left",
            fontsize=9,
        )
    panels[0][0].set_ylabel("mean F1 of the dominant plane")
    libraries = list(dict.fromkeys(row.library for row in seen))
    methods = [method for method in METHOD_MARKERS if any(row.method == method for row in seen)]
    handles = [
        Line2D([], [], linestyle="none", marker="o", markersize=7, color=LIBRARY_COLOURS[library]) for library in libraries
    ]
    names = [LIBRARY_NAMES[library] for library in libraries]
    handles.append(Line2D([], [], linestyle="none", marker="o", markersize=7, color="#444444", markerfacecolor="white"))
    names.append("Debian's build")
    handles += [
        Line2D([], [], linestyle="none", marker=METHOD_MARKERS[method], markersize=7, color="#444444") for method in methods
    ]
    names += methods
    figure.legend(handles, names, loc="lower center", ncol=6, fontsize=8)
    figure.subplots_adjust(left=0.08, right=0.98, top=0.94, bottom=0.25, wspace=0.2)
    return figure


def stages(results: Results) -> Figure | None:
    bars: list[tuple[str, Summary]] = []
    for dataset in results.datasets("segment"):
        found = results.summaries(suite="segment", dataset=dataset, library="fransac", threads=1)
        bars += [(f"{peer}\n{dataset}", summary) for peer, summary in found.items() if summary.stages_ms]
    if not bars:
        return None
    figure, axes = plt.subplots(figsize=(8.2, 0.8 + 0.42 * len(bars)))
    names = [name for name in STAGE_COLOURS if any(summary.stages_ms.get(name) for _, summary in bars)]
    for place, (_, summary) in enumerate(bars):
        left = 0.0
        for name in names:
            width = summary.stages_ms.get(name, 0.0)
            axes.barh(place, width, left=left, color=STAGE_COLOURS[name], edgecolor="white", linewidth=0.5, height=0.7)
            left += width
        axes.annotate(f"{left:.2f} ms", (left, place), xytext=(4, 0), textcoords="offset points", va="center", fontsize=8)
    axes.set_yticks(range(len(bars)), [name for name, _ in bars], fontsize=8)
    axes.invert_yaxis()
    axes.grid(axis="y", visible=False)
    axes.margins(x=0.12)
    axes.set_xlabel("milliseconds per frame, medians over frames, one thread")
    axes.legend(
        [plt.Rectangle((0, 0), 1, 1, color=STAGE_COLOURS[name]) for name in names],
        [name.replace("_", " ") for name in names],
        loc="lower left",
        bbox_to_anchor=(0.0, 1.0),
        ncol=len(names),
        fontsize=8,
    )
    figure.tight_layout()
    return figure


def _scaling(axes: Axes, rows: list[Row], size: Callable[[Row], int]) -> None:
    """One line per peer; call _label_peers when the axes are in their place."""
    for peer in dict.fromkeys(row.peer for row in rows):
        own = [row for row in rows if row.peer == peer]
        sizes = sorted({size(row) for row in own})
        times = [median(row.time.median for row in own if row.time and size(row) == x) for x in sizes]
        ours = own[0].library == "fransac"
        axes.plot(
            sizes,
            times,
            label=peer,
            linewidth=2.2 if ours else 1.0,
            markersize=7 if ours else 4.5,
            zorder=3 if ours else 2,
            **_marker(own[0]),
        )
    axes.set_xscale("log")
    axes.set_yscale("log")
    _plain_ticks(axes.xaxis, *axes.get_xlim())
    _plain_ticks(axes.yaxis, *axes.get_ylim())
    axes.set_ylabel("median time [ms], one thread")


def _label_peers(axes: Axes) -> None:
    _label_ends(axes, [(line.get_xdata()[-1], line.get_ydata()[-1], line.get_label(), line.get_color()) for line in axes.lines])


def resolution(results: Results) -> Figure | None:
    rows = [row for row in results.select(suite="resolution") if row.time]
    if not rows:
        return None
    figure, axes = plt.subplots(figsize=(8.2, 4.4))
    _scaling(axes, rows, lambda row: row.width * row.height)
    sizes = sorted({(row.width * row.height, f"{row.width}×{row.height}") for row in rows})
    axes.set_xticks([pixels for pixels, _ in sizes], [name for _, name in sizes], rotation=20, fontsize=8)
    axes.set_xticks([], minor=True)
    axes.set_xlabel("pixels of the depth frame")
    figure.subplots_adjust(left=0.095, right=0.82, top=0.97, bottom=0.17)
    _label_peers(axes)
    return figure


def points(results: Results) -> Figure | None:
    """Methods above, voxel grids alone below."""
    rows = [row for row in results.select(suite="points") if row.time]
    groups = [
        ("a plane and labels", [row for row in rows if row.method != "voxel-grid"]),
        ("voxel grid alone", [row for row in rows if row.method == "voxel-grid"]),
    ]
    groups = [group for group in groups if group[1]]
    if not groups:
        return None
    figure, panels = plt.subplots(len(groups), 1, figsize=(8.2, 4.0 * len(groups)), squeeze=False)
    for axes, (title, own) in zip(panels[:, 0], groups):
        _scaling(axes, own, lambda row: row.points)
        axes.set_title(title, loc="left", fontsize=9)
        axes.set_xlabel("points of the cloud")
    figure.subplots_adjust(left=0.095, right=0.72, top=0.96, bottom=0.07, hspace=0.28)
    for axes in panels[:, 0]:
        _label_peers(axes)
    return figure


FIGURES: dict[str, Callable[[Results], Figure | None]] = {
    "fps-by-scene": fps_by_scene,
    "accuracy-speed": accuracy_speed,
    "stages": stages,
    "resolution": resolution,
    "points": points,
}


def draw(results: Results, folder: pathlib.Path, png: bool = False) -> list[str]:
    """Writes FOLDER/NAME.svg, the same bytes for the same results, and returns the names drawn. `png` is for looking at them."""
    folder.mkdir(parents=True, exist_ok=True)
    drawn = []
    with plt.rc_context(STYLE):
        for name, figure_of in FIGURES.items():
            figure = figure_of(results)
            if figure is None:
                (folder / f"{name}.svg").unlink(missing_ok=True)
                continue
            figure.savefig(folder / f"{name}.svg", metadata={"Date": None})
            if png:
                figure.savefig(folder / f"{name}.png", dpi=110)
            plt.close(figure)
            drawn.append(name)
    return drawn
