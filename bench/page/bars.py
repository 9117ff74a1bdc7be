# SPDX-License-Identifier: Apache-2.0
"""What we set out to reach, one function per bar. A bar's limit is the only number that stands here; the rest is measured."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator

import accuracy
from results import Results, Row, complete_scores, mean, median, ratio, scores, summarise

DATASETS = ("mosd", "tum")
LARGE = "azure"  # one frame of 1920 x 1080 pixels


@dataclasses.dataclass(frozen=True)
class Claim:
    what: str
    where: str
    relation: str  # "≤" or "≥"
    limit: float
    measured: float | None
    unit: str = "×"
    slack: float = 0.0  # a miss by this much counts as met

    @property
    def met(self) -> bool | None:
        if self.measured is None:
            return None
        over = self.measured - self.limit
        return over <= self.slack if self.relation == "≤" else over >= -self.slack

    @property
    def verdict(self) -> str:
        if self.measured is None or self.met is None:
            return "not measured"
        if self.met:
            return "met"
        if self.unit:
            return f"missed by {abs(self.measured / self.limit - 1):.0%}"
        return f"missed by {abs(self.measured - self.limit):.4f}"


def times_faster(results: Results, ours: list[Row], rivals: list[Row], dataset: str) -> float | None:
    """Against the rival that is fastest on this dataset."""
    own = [row for row in ours if row.dataset == dataset]
    by_peer: dict[str, list[Row]] = {}
    for row in rivals:
        if row.dataset == dataset:
            by_peer.setdefault(row.peer, []).append(row)
    ratios = [value for rows in by_peer.values() if (value := ratio(rows, own)) is not None]
    return min(ratios, default=None)


def our(results: Results, method: str) -> list[Row]:
    return results.select(suite="segment", library="fransac", method=method, threads=1)


def pcl(results: Results, method: str, build: str) -> list[Row]:
    return results.select(suite="segment", library="pcl", method=method, build=build, threads=1)


def floor_bar(results: Results) -> Iterator[Claim]:
    floor = results.select(suite="floor", peer="floor-deproject")
    for dataset in DATASETS:
        value = ratio((row for row in our(results, "fransac") if row.dataset == dataset), floor)
        yield Claim("`fransac` / plain deprojection loop", dataset, "≤", 8.0, value)


def fransac_bar(results: Results) -> Iterator[Claim]:
    for build, dataset, limit in (("native", "mosd", 10.0), ("native", "tum", 15.0), ("packaged", "tum", 60.0)):
        value = times_faster(results, our(results, "fransac"), pcl(results, "fransac", build), dataset)
        yield Claim(f"`fransac` faster than FRANSAC of PCL parts, {build}", dataset, "≥", limit, value)


def voxel_grid_bar(results: Results) -> Iterator[Claim]:
    ours = results.select(suite="voxel_grid", peer="voxel-grid-depth")
    pcl_rows = results.select(suite="voxel_grid", library="pcl")
    approximate = [row for row in pcl_rows if "approximate" in row.peer]
    exact = [row for row in pcl_rows if "approximate" not in row.peer and row.build == "native"]
    open3d = results.select(suite="voxel_grid", library="open3d")
    for name, rivals, limit in (
        ("PCL `VoxelGrid`, native", exact, 10.0),
        ("PCL `ApproximateVoxelGrid`, its faster build", approximate, 4.0),
        ("Open3D `voxel_down_sample`", open3d, 9.0),
    ):
        for dataset in DATASETS:
            yield Claim(f"voxel grid faster than {name}", dataset, "≥", limit, times_faster(results, ours, rivals, dataset))


def ransac_bar(results: Results) -> Iterator[Claim]:
    for dataset, limit in (("mosd", 4.0), ("tum", 6.0)):
        value = times_faster(results, our(results, "ransac"), pcl(results, "ransac", "native"), dataset)
        yield Claim("`ransac` faster than PCL's, native", dataset, "≥", limit, value)


def rransac_bar(results: Results) -> Iterator[Claim]:
    for dataset in DATASETS:
        value = times_faster(results, our(results, "rransac"), pcl(results, "rransac", "native"), dataset)
        yield Claim("`rransac` faster than PCL's, native", dataset, "≥", 4.0, value)


def label_bar(results: Results) -> Iterator[Claim]:
    """Our stage `labels` inside `fransac`, with one plane, against the plain loop with that plane."""
    for dataset in DATASETS:
        floor = results.select(suite="floor", peer="floor-label", dataset=dataset)
        own = [row for row in our(results, "fransac") if row.dataset == dataset and row.time]
        value = None
        if own and any(row.time for row in floor):
            value = median(row.stages_ms["labels"] for row in own) / median(row.time.median for row in floor if row.time)
        yield Claim("labels of one plane / plain labelling loop", dataset, "≤", 1.5, value)


def latency_bar(results: Results) -> Iterator[Claim]:
    for dataset in DATASETS:
        time = summarise(row for row in our(results, "fransac") if row.dataset == dataset).time
        yield Claim("`fransac`: p99 / median", dataset, "≤", 1.5, time.p99 / time.median if time else None)


def same_name_bar(results: Results) -> Iterator[Claim]:
    """Each rival of the same name by its best build; mean F1 over the dataset's frames."""
    for dataset in DATASETS:
        for peer, own in results.summaries(suite="segment", library="fransac", dataset=dataset, threads=1).items():
            if peer not in accuracy.METHODS:
                continue
            rivals = results.summaries(suite="segment", method=own.first.method, dataset=dataset, threads=1)
            best = max(
                ((rival.f1, name) for name, rival in rivals.items() if rival.first.library != "fransac" and rival.f1 is not None),
                default=None,
            )
            if own.f1 is not None and best:
                yield Claim(f"`{peer}`: mean F1, against `{best[1]}`", dataset, "≥", best[0], own.f1, unit="", slack=0.001)


# Mean F1 before any of this work on speed: `fransac evaluate` with the defaults, mean over seeds 0 to 19.
F1_BEFORE = {
    ("mosd", "fransac"): 0.99704,
    ("mosd", "voxel-ransac"): 0.99704,
    ("mosd", "rransac"): 0.99695,
    ("mosd", "ransac"): 0.99695,
    ("tum", "fransac"): 0.52078,
    ("tum", "voxel-ransac"): 0.51172,
    ("tum", "rransac"): 0.42731,
    ("tum", "ransac"): 0.45815,
}


def before_bar(results: Results) -> Iterator[Claim]:
    now = {
        (row["dataset"], row["method"]): row["f1"]
        for row in results.accuracy
        if row["setting"] == "default" and row["scene"] == "mean" and row["seeds"] == accuracy.SEEDS
    }
    for (dataset, method), limit in F1_BEFORE.items():
        yield Claim(
            f"`{method}`: mean F1 over {accuracy.SEEDS} seeds, against before",
            dataset,
            "≥",
            limit,
            now.get((dataset, method)),
            unit="",
            slack=0.001,
        )


def mosd_bar(results: Results) -> Iterator[Claim]:
    for peer, own in results.summaries(suite="segment", library="fransac", dataset="mosd", threads=1).items():
        if peer not in accuracy.METHODS:
            continue
        yield Claim(f"`{peer}`: mean F1 with refinement", "mosd", "≥", 0.9965, own.f1, unit="")


def threads_bar(results: Results) -> Iterator[Claim]:
    rows = [
        row
        for row in results.select(suite="threads", library="fransac", method="fransac")
        if row.height > 1 and row.dataset != LARGE
    ]
    pixels = sorted({row.width * row.height for row in rows})
    if not pixels:
        yield Claim("`fransac`: two threads, speed-up", "1920x1080", "≥", 1.6, None)
        return
    for size, limit in ((pixels[-1], 1.6), (pixels[0], 1.0)):
        of_size = [row for row in rows if row.width * row.height == size]
        value = ratio((row for row in of_size if row.threads == 1), (row for row in of_size if row.threads == 2))
        yield Claim("`fransac`: two threads, speed-up", f"{of_size[0].width}x{of_size[0].height}", "≥", limit, value)


def cells(results: Results, **wanted: object) -> list[Row]:
    return results.select(peer="cells", **({"suite": "planes"} | wanted))


def either(*claims: Claim) -> Claim:
    """Bars of which one is enough: the one that is met best."""
    measured = [claim for claim in claims if claim.measured is not None]
    return min(measured, key=lambda claim: claim.measured / claim.limit, default=claims[0])


def cells_time_bar(results: Results) -> Iterator[Claim]:
    """Within a time, or within a multiple of the deprojection loop that takes turns with it."""
    for dataset in DATASETS:
        times = {row.frame: row.time.median for row in cells(results, dataset=dataset) if row.time}
        floor = {row.frame: row.time.median for row in results.select(suite="planes", peer="floor-deproject") if row.time}
        quotients = [time / floor[frame] for frame, time in times.items() if frame in floor]
        for what, of, ms, multiple in (("mean frame", mean, 0.25, 5.0), ("worst frame", max, 0.35, 7.0)):
            yield either(
                Claim(f"`cells`, {what}", dataset, "≤", ms, of(times.values()) if times else None, unit=" ms"),
                Claim(f"`cells` / plain deprojection loop, {what}", dataset, "≤", multiple, of(quotients) if quotients else None),
            )
    for threads, limit in ((1, 1.8), (2, 1.1)):
        time = summarise(cells(results, suite="threads", dataset=LARGE, threads=threads)).time
        words = "one thread" if threads == 1 else "two threads"
        yield Claim(f"`cells`, {words}", "1920x1080", "≤", limit, time.median if time else None, unit=" ms")


def cells_accuracy_bar(results: Results) -> Iterator[Claim]:
    for dataset, figure, what, of, limit in (
        ("tum", "instance_f1_50", "instance F1 at IoU 0.5", mean, 0.88),
        ("tum", "instance_f1_75", "instance F1 at IoU 0.75", mean, 0.86),
        ("tum", "weighted_iou", "area-weighted IoU", mean, 0.96),
        ("tum", "matched_f1", "matched F1 of the first plane", mean, 0.99),
        ("tum", "matched_f1", "matched F1 of the first plane, worst frame", min, 0.98),
        ("tum", "plane_pixel_f1", "F1 of plane pixels", mean, 0.975),
        ("icl_nuim", "instance_f1_50", "instance F1 at IoU 0.5", mean, 0.85),
        ("mosd", "f1", "F1 of the dominant plane", mean, 0.997),
        ("mosd", "f1", "F1 of the dominant plane, worst frame", min, 0.988),
    ):
        values = scores(cells(results, dataset=dataset), figure)
        yield Claim(f"`cells`: {what}", dataset, "≥", limit, of(values) if values else None, unit="")


def obstacles_bar(results: Results) -> Iterator[Claim]:
    """Planes and what is on top of them, where objects touch and are stacked; the rival that finds objects best counts."""
    found = results.summaries(suite="objects", dataset="mosd", threads=1)
    f1 = {peer: mean(values) for peer, values in complete_scores(found, "object_f1_50").items()}
    own = f1.pop("obstacles", None)
    rival = max(f1, key=lambda peer: f1[peer], default=None)
    lead = own - f1[rival] if own is not None and rival else None
    yield Claim("`obstacles`: object F1 at IoU 0.5", "mosd", "≥", 0.90, own, unit="")
    yield Claim(f"`obstacles`: the same, above {f'`{rival}`' if rival else 'the best rival'}", "mosd", "≥", 0.05, lead, unit="")
    time = found["obstacles"].time if "obstacles" in found else None
    quotient = ratio(found["obstacles"].rows, found["floor-deproject"].rows) if time and "floor-deproject" in found else None
    yield either(
        Claim("`cells` and `obstacles`, median frame", "mosd", "≤", 0.7, time.median if time else None, unit=" ms"),
        Claim("`cells` and `obstacles` / plain deprojection loop, median frame", "mosd", "≤", 14.0, quotient),
    )


def adapter_bar(results: Results) -> Iterator[Claim]:
    """The adapter against the class in whose place it stands, on the same cloud."""
    for suite, peer, method in (("sac", "adapter-sac", "SACSegmentation"), ("voxel_grid", "adapter-voxelgrid", "VoxelGrid")):
        ours = results.select(suite=suite, peer=peer)
        for build, limit in (("packaged", 8.0), ("native", 3.0)):
            rivals = [row for row in results.select(suite=suite, library="pcl", build=build) if "approximate" not in row.peer]
            value = times_faster(results, ours, rivals, "tum")
            yield Claim(f"`fransac::pcl::{method}` faster than PCL's, {build}", "tum", "≥", limit, value)


BARS: tuple[Callable[[Results], Iterator[Claim]], ...] = (
    cells_time_bar,
    cells_accuracy_bar,
    obstacles_bar,
    floor_bar,
    fransac_bar,
    voxel_grid_bar,
    adapter_bar,
    ransac_bar,
    rransac_bar,
    label_bar,
    latency_bar,
    threads_bar,
    same_name_bar,
    before_bar,
    mosd_bar,
)


def claims(results: Results) -> list[Claim]:
    return [claim for bar in BARS for claim in bar(results)]
