# SPDX-License-Identifier: Apache-2.0
"""Results as text and as HTML."""

import base64
from html import escape

import numpy
from numpy.typing import NDArray

from ._core import Evaluation, Obstacle, Plane, RansacResult, Segmentation, png_of


def _vector(values: NDArray[numpy.float64]) -> str:
    return "(" + ", ".join(f"{value:.3f}" for value in values) + ")"


def plane(p: Plane) -> str:
    return f"<Plane {p.id} {p.kind}: {p.area_m2:.2f} m2, {p.inliers} inliers, rms {1e3 * p.rms_m:.1f} mm, n {_vector(p.normal)}, d {p.d:.3f}>"


def obstacle(o: Obstacle) -> str:
    size = " x ".join(f"{edge:.2f}" for edge in o.box.size)
    return f"<Obstacle {o.id} {o.kind}: {size} m, {o.nearest_m:.2f} m away, {o.min_height_m:.2f} to {o.max_height_m:.2f} m high>"


def ransac(r: RansacResult) -> str:
    return f"<RansacResult: {len(r.inliers)} inliers, rms {1e3 * r.rms_m:.1f} mm, n {_vector(r.normal)}, d {r.d:.3f}, {r.stop_reason}>"


def evaluation(e: Evaluation) -> str:
    at50 = e.planes.at50
    return (
        f"<Evaluation: plane 1 f1 {e.dominant.f1:.3f}; {at50.matched} of {e.planes.true_planes} planes matched at IoU 0.5, f1 {at50.f1:.3f}>"
    )


def _title(s: Segmentation) -> str:
    size = " x ".join(str(side) for side in reversed(s.labels.shape))
    planes = "1 plane" if len(s.planes) == 1 else f"{len(s.planes)} planes"
    count = len(s.obstacles)
    obstacles = "" if s.obstacle_labels is None else f", {count} obstacle{'' if count == 1 else 's'}"
    unit = "points" if s.labels.ndim == 1 else "pixels"
    return f"Segmentation of {size} {unit} by {s.method}: {planes}{obstacles} in {s.timing_ms['total']:.2f} ms"


_MOST_LINES = 12


def segmentation(s: Segmentation) -> str:
    things: list[Plane | Obstacle] = [*s.planes, *s.obstacles]
    lines = [f"  {thing!r}" for thing in things[:_MOST_LINES]]
    if len(things) > _MOST_LINES:
        lines.append(f"  ... and {len(things) - _MOST_LINES} more")
    if s.note is not None:
        lines.append(f"  {s.note}")
    return "\n".join([_title(s), *lines])


def html(s: Segmentation) -> str:
    """The picture, where there is one, beside a table of the planes."""
    picture = ""
    if s.camera is not None:
        data = base64.b64encode(png_of(s)).decode("ascii")
        picture = f'<img alt="planes" style="max-width:480px" src="data:image/png;base64,{data}">'
    head = "".join(f"<th>{name}</th>" for name in ("plane", "kind", "m²", "inliers", "rms mm", "normal", "d m"))
    rows = "".join(
        f"<tr><td>{p.id}</td><td>{escape(p.kind)}</td><td>{p.area_m2:.2f}</td><td>{p.inliers}</td><td>{1e3 * p.rms_m:.1f}</td>"
        f"<td>{_vector(p.normal)}</td><td>{p.d:.3f}</td></tr>"
        for p in s.planes
    )
    return f"<div><p>{escape(_title(s))}</p>{picture}<table><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table></div>"
