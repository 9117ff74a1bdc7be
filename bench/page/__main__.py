# SPDX-License-Identifier: Apache-2.0
"""From the results of bench_peers to the pages and the README's table: `python3 bench/page COMMAND …`. scripts/bench calls it."""

from __future__ import annotations

import argparse
import importlib.util
import json
import pathlib
import sys

import accuracy
import micro
import page
import results

DOCS = pathlib.Path(__file__).resolve().parents[2] / "docs"
PAGES = (DOCS / "benchmark.md", DOCS / "reproduction.md", DOCS.parent / "README.md")


def measure(arguments: argparse.Namespace) -> None:
    table = accuracy.measure(arguments.program, arguments.dataset, arguments.seeds)
    arguments.out.write_text(json.dumps(table) + "\n", encoding="utf-8")


def add_micro(arguments: argparse.Namespace) -> None:
    text = json.loads(arguments.results.read_text(encoding="utf-8"))
    text["rows"] += micro.rows(arguments.report)
    arguments.results.write_text(json.dumps(text) + "\n", encoding="utf-8")


def render(arguments: argparse.Namespace) -> None:
    """The pages of DOCS with their blocks filled, their plots and the compact results, into OUT."""
    found = results.compact(results.load(arguments.results, arguments.accuracy))
    folder = arguments.out / "benchmark"
    results.save(found, folder / "results.json")
    if not importlib.util.find_spec("matplotlib"):
        sys.exit("bench/page: no matplotlib; scripts/bootstrap bench installs it")
    import plots

    drawn = plots.draw(found, folder, png=arguments.png)
    for source in PAGES:
        filled = page.fill(source.read_text(encoding="utf-8"), found, drawn)
        out = source if arguments.out == DOCS else arguments.out / source.name
        out.write_text(filled, encoding="utf-8")
        print(out)


def main() -> None:
    parser = argparse.ArgumentParser(prog="bench/page", description=__doc__)
    commands = parser.add_subparsers(required=True)
    one = commands.add_parser("accuracy", help="runs `fransac evaluate` over settings and seeds")
    one.add_argument("program", type=pathlib.Path)
    one.add_argument("dataset", type=pathlib.Path, nargs="+")
    one.add_argument("--seeds", type=int, default=accuracy.SEEDS)
    one.add_argument("--out", type=pathlib.Path, required=True)
    one.set_defaults(run=measure)
    one = commands.add_parser("micro", help="adds reports of Google Benchmark to the results of bench_peers")
    one.add_argument("results", type=pathlib.Path)
    one.add_argument("report", type=pathlib.Path, nargs="+")
    one.set_defaults(run=add_micro)
    one = commands.add_parser("render", help="fills the pages and draws the plots")
    one.add_argument("results", type=pathlib.Path, help="JSON of bench_peers, or docs/benchmark/results.json")
    one.add_argument("--accuracy", type=pathlib.Path, help="what `accuracy` wrote")
    one.add_argument("--out", type=pathlib.Path, default=DOCS)
    one.add_argument("--png", action="store_true", help="plots as PNG as well")
    one.set_defaults(run=render)
    arguments = parser.parse_args()
    arguments.run(arguments)


if __name__ == "__main__":
    main()
