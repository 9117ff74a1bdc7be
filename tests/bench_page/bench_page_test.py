# SPDX-License-Identifier: Apache-2.0
"""How results of the benchmark become the figures of its page."""

import importlib.util
import json
import os
import pathlib
import sys
import tempfile
import unittest

SOURCE = pathlib.Path(os.environ["FRANSAC_SOURCE_DIR"])
sys.path.insert(0, str(SOURCE / "bench" / "page"))

import accuracy  # noqa: E402
import bars  # noqa: E402
import page  # noqa: E402
import results  # noqa: E402

HAS_MATPLOTLIB = importlib.util.find_spec("matplotlib") is not None


def raw_row(peer, method, library, build, times_ms, *, suite="segment", dataset="tum", scene="scene1", f1=None, **more):
    return (
        {
            "suite": suite,
            "peer": peer,
            "library": library,
            "build": build,
            "method": method,
            "dataset": dataset,
            "scene": scene,
            "width": 640,
            "height": 480,
            "points": 300000,
            "threads": 1,
            "times_ms": times_ms,
        }
        | ({} if f1 is None else {"precision": f1, "recall": f1, "f1": f1, "best_f1": f1})
        | more
    )


def ours(times_ms, method="fransac", **more):
    stages = {"deproject": 0.1, "labels": 0.06}
    return raw_row(method, method, "fransac", "project", times_ms, **({"stages_ms": stages} | more))


def pcl(times_ms, method="fransac", build="native", **more):
    return raw_row(f"pcl-{method}-{build}", method, "pcl", build, times_ms, **more)


def floor(name, times_ms, **more):
    return raw_row(name, "floor", "floor", "native", times_ms, suite="floor", **more)


def finds_objects(peer, time_ms, scene="learn00", **figures):
    library = {"obstacles": "fransac", "floor-deproject": "floor"}.get(peer, "pcl")
    build = {"fransac": "project"}.get(library, "native")
    times_ms = [] if time_ms is None else [time_ms]
    return raw_row(peer, "objects", library, build, times_ms, suite="objects", dataset="mosd", scene=scene, **figures)


def loaded(rows, accuracy_rows=()):
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "results.json"
        path.write_text(
            json.dumps(
                {"machine": {"cpu": "abacus"}, "command": "bench_peers", "rows": list(rows), "accuracy": list(accuracy_rows)}
            )
        )
        return results.load(path)


class Statistics(unittest.TestCase):
    def test_quantiles_are_nearest_rank(self):
        hundred = list(range(1, 101))
        self.assertEqual(results.quantile(hundred, 0.99), 99)
        self.assertEqual(results.quantile(hundred, 0.0), 1)
        self.assertEqual(results.quantile(hundred, 1.0), 100)
        self.assertEqual(results.median([4, 1, 3, 2]), 2)
        self.assertEqual(results.quantile([5, 7], 0.99), 7)
        with self.assertRaises(ValueError):
            results.median([])

    def test_a_dataset_is_the_median_of_its_frames(self):
        found = loaded(
            [
                ours([1.0, 3.0, 2.0], scene="a", f1=0.5),
                ours([10.0, 30.0, 20.0], scene="b", f1=1.0),
                ours([5.0, 5.0, 9.0], scene="c", f1=0.6),
            ]
        )
        summary = results.summarise(found.rows)
        self.assertEqual(summary.time, results.Time(min=5.0, median=5.0, p99=9.0))
        self.assertEqual(summary.fps, 200.0)
        self.assertAlmostEqual(summary.f1, 0.7)
        self.assertEqual(summary.runs, 3)

    def test_frames_that_were_not_timed_are_counted_and_explained(self):
        found = loaded([pcl([2.0], scene="a", f1=1.0), pcl([], scene="b", f1=0.0, note="not timed: 9 s a run")])
        summary = results.summarise(found.rows)
        self.assertEqual((summary.frames, summary.timed, summary.notes), (2, 1, ["not timed: 9 s a run"]))
        self.assertEqual(summary.time.median, 2.0)
        self.assertEqual(summary.f1, 0.5)

    def test_a_ratio_uses_only_frames_that_both_were_timed_on(self):
        found = loaded(
            [ours([1.0], scene="a"), ours([100.0], scene="b"), pcl([6.0], scene="a"), pcl([], scene="b", note="too slow")]
        )
        self.assertEqual(results.ratio(found.select(library="pcl"), found.select(library="fransac")), 6.0)
        self.assertIsNone(results.ratio(found.select(library="pcl", scene="b"), found.select(library="fransac")))

    def test_seeds_are_averaged_per_scene_and_then_over_scenes(self):
        runs = [
            [
                {"dataset": "x/tum", "scene": "a", "method": "ransac", "f1": f1, "best_f1": None},
                {"dataset": "x/tum", "scene": "b", "method": "ransac", "f1": 0.5},
            ]
            for f1 in (0.0, 1.0)
        ]
        table = accuracy.aggregate("paper", runs)
        self.assertEqual(
            [(row["scene"], row["f1"], row["f1_sd"], row["seeds"]) for row in table],
            [("a", 0.5, 0.5, 2), ("b", 0.5, 0.0, 2), ("mean", 0.5, 0.25, 2)],
        )
        self.assertNotIn("best_f1", table[0])

    def test_the_compact_form_reads_back_as_it_was(self):
        found = results.compact(
            loaded([ours([1.23456789, 2.0], f1=1 / 3, leaves=7), pcl([], note="gone")], [{"setting": "paper", "f1": 2 / 3}])
        )
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "compact.json"
            results.save(found, path)
            first = path.read_bytes()
            self.assertEqual(results.load(path), found)
            results.save(results.load(path), path)
            self.assertEqual(path.read_bytes(), first)


    def test_figures_that_older_results_lack_are_missing(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "compact.json"
            results.save(loaded([ours([1.0], matched_f1=0.5)]), path)
            text = json.loads(path.read_text())
            older = len(text["columns"]) - len(results.SCORES)
            text["columns"], text["rows"] = text["columns"][:older], [row[:older] for row in text["rows"]]
            path.write_text(json.dumps(text))
            (row,) = results.load(path).rows
            self.assertEqual((row.peer, row.matched_f1), ("fransac", None))
            text["columns"][0] = "suit"
            path.write_text(json.dumps(text))
            with self.assertRaises(ValueError):
                results.load(path)


class Bars(unittest.TestCase):
    def verdict(self, relation, limit, measured, **more):
        return bars.Claim("", "", relation, limit, measured, **more).verdict

    def test_verdicts(self):
        self.assertEqual(self.verdict("≤", 8.0, 8.0), "met")
        self.assertEqual(self.verdict("≤", 8.0, 10.0), "missed by 25%")
        self.assertEqual(self.verdict("≥", 10.0, 9.0), "missed by 10%")
        self.assertEqual(self.verdict("≥", 10.0, None), "not measured")
        self.assertEqual(self.verdict("≥", 0.9, 0.8995, unit="", slack=0.001), "met")
        self.assertEqual(self.verdict("≥", 0.9, 0.8985, unit="", slack=0.001), "missed by 0.0015")

    def claims(self, bar, rows, accuracy_rows=()):
        return {
            (claim.what, claim.where): claim.measured for claim in bar(loaded(rows, accuracy_rows)) if claim.measured is not None
        }

    def test_times_against_the_floor_and_pcl(self):
        rows = [
            ours([0.4]),
            floor("floor-deproject", [0.05]),
            floor("floor-label", [0.04]),
            pcl([6.0]),
            pcl([24.0], build="packaged"),
            pcl([1.0], method="ransac"),
        ]
        self.assertEqual(list(self.claims(bars.floor_bar, rows).values()), [0.4 / 0.05])
        self.assertEqual(sorted(self.claims(bars.fransac_bar, rows).values()), [6.0 / 0.4, 24.0 / 0.4])
        self.assertEqual(list(self.claims(bars.label_bar, rows).values()), [0.06 / 0.04])

    def test_the_fastest_rival_counts(self):
        grid = {"suite": "voxel_grid", "method": "voxel-grid"}
        rows = [
            raw_row("voxel-grid-depth", library="fransac", build="project", times_ms=[1.0], **grid),
            raw_row("pcl-voxelgrid-native", library="pcl", build="native", times_ms=[9.0], **grid),
            raw_row("pcl-approximate-voxelgrid-native", library="pcl", build="native", times_ms=[5.0], **grid),
            raw_row("pcl-approximate-voxelgrid-packaged", library="pcl", build="packaged", times_ms=[3.0], **grid),
        ]
        self.assertEqual(sorted(self.claims(bars.voxel_grid_bar, rows).values()), [3.0, 9.0])

    def test_two_threads_on_the_largest_and_the_smallest_image(self):
        rows = [
            ours([ms], suite="threads", threads=threads, scene=scene, width=width, height=height)
            for scene, width, height, one, two in (
                ("vga", 640, 480, 1.0, 1.25),
                ("hd", 1920, 1080, 6.0, 3.0),
                ("cloud", 10**7, 1, 9.0, 1.0),
            )
            for threads, ms in ((1, one), (2, two))
        ]
        self.assertEqual([claim.measured for claim in bars.threads_bar(loaded(rows))], [2.0, 0.8])

    def all_planes(self, time_ms, scene, dataset="tum", peer="cells", **figures):
        library = "fransac" if peer == "cells" else "opencv"
        return raw_row(peer, "multi-plane", library, "project", [time_ms], suite="planes", dataset=dataset, scene=scene, **figures)

    def test_cells_may_meet_the_time_or_the_multiple_of_the_floor(self):
        floors = [
            raw_row("floor-deproject", "floor", "floor", "native", [ms], suite="planes", scene=scene)
            for scene, ms in (("a", 0.1), ("b", 0.2))
        ]
        slow = [self.all_planes(0.6, "a"), self.all_planes(0.8, "b"), *floors]
        mean, worst = (claim for claim in bars.cells_time_bar(loaded(slow)) if claim.where == "tum")
        self.assertEqual((mean.unit, worst.unit, mean.met, worst.met), ("×", "×", True, True))
        self.assertAlmostEqual(mean.measured, 5.0)
        self.assertAlmostEqual(worst.measured, 6.0)
        fast = [self.all_planes(0.2, "a"), self.all_planes(0.3, "b")]
        mean, worst = (claim for claim in bars.cells_time_bar(loaded(fast)) if claim.where == "tum")
        self.assertEqual((mean.measured, worst.measured, worst.unit), (0.25, 0.3, " ms"))
        missed = bars.Claim("", "", "≤", 0.25, 0.5, unit=" ms")
        self.assertEqual(missed.verdict, "missed by 100%")

    def test_accuracy_of_cells_is_the_mean_and_the_worst_of_its_frames(self):
        rows = [
            self.all_planes(0.2, scene, f1=0.5, matched_f1=matched, instance_f1_50=0.9)
            for scene, matched in (("a", 1.0), ("b", 0.98))
        ]
        rows.append(self.all_planes(5.0, "a", peer="opencv-rgbdplane", matched_f1=0.1))
        found = self.claims(bars.cells_accuracy_bar, rows)
        self.assertAlmostEqual(found["`cells`: matched F1 of the first plane", "tum"], 0.99)
        self.assertEqual(found["`cells`: matched F1 of the first plane, worst frame", "tum"], 0.98)
        self.assertEqual(found["`cells`: instance F1 at IoU 0.5", "tum"], 0.9)
        self.assertNotIn(("`cells`: F1 of the dominant plane", "mosd"), found)

    def test_objects_are_compared_with_the_rival_that_finds_them_best(self):
        rows = [
            finds_objects("obstacles", 0.6, "a", object_f1_50=0.8),
            finds_objects("obstacles", 0.8, "b", object_f1_50=1.0),
            finds_objects("obstacles", 0.9, "c", object_f1_50=0.99),
            finds_objects("obstacles", 0.1, "no objects", false_objects=0),
            finds_objects("pcl-clusters-packaged", 90.0, "a", object_f1_50=1.0),
            finds_objects("pcl-clusters-packaged", None, "b", note="skipped: about 9 s a run"),
        ]
        rows += [finds_objects("pcl-clusters-native", 90.0, scene, object_f1_50=0.5) for scene in "abc"]
        rows += [
            finds_objects("pcl-voxel-clusters-native", None, scene, object_f1_50=0.9, note="not timed: 9 s a run")
            for scene in "abc"
        ]
        found, lead, time = bars.obstacles_bar(loaded(rows))
        self.assertEqual((found.limit, found.met), (0.9, True))
        self.assertAlmostEqual(found.measured, 0.93)
        self.assertIn("pcl-voxel-clusters-native", lead.what)
        self.assertAlmostEqual(lead.measured, 0.03)
        self.assertEqual((lead.limit, lead.verdict), (0.05, "missed by 0.0200"))
        self.assertEqual((time.measured, time.limit, time.unit, time.met), (0.6, 0.7, " ms", True))

    def test_obstacles_may_meet_the_time_or_the_multiple_of_the_floor_of_the_same_run(self):
        rows = [
            finds_objects("obstacles", 1.3, "a"),
            finds_objects("floor-deproject", 0.1, "a"),
            floor("floor-deproject", [0.001], dataset="mosd", scene="a"),
        ]
        *accuracies, time = bars.obstacles_bar(loaded(rows))
        self.assertEqual([claim.verdict for claim in accuracies], ["not measured", "not measured"])
        self.assertEqual((time.unit, time.limit, time.met), ("×", 14.0, True))
        self.assertAlmostEqual(time.measured, 13.0)
        *_, time = bars.obstacles_bar(loaded([finds_objects("obstacles", 1.3, "a"), finds_objects("floor-deproject", 0.08, "a")]))
        self.assertIs(time.met, False)
        *_, alone = bars.obstacles_bar(loaded(rows[:1]))
        self.assertEqual((alone.unit, alone.measured, alone.met), (" ms", 1.3, False))

    def test_accuracy_is_compared_with_the_best_rival_of_the_name(self):
        rows = [
            ours([1.0], f1=0.9),
            pcl([1.0], f1=0.8),
            pcl([1.0], build="packaged", f1=0.95),
            pcl([1.0], method="ransac", f1=1.0),
        ]
        (claim,) = bars.same_name_bar(loaded(rows))
        self.assertEqual((claim.limit, claim.measured, claim.met), (0.95, 0.9, False))

    def test_before_is_compared_over_the_same_seeds(self):
        rows = [
            {"setting": "default", "dataset": "mosd", "scene": "mean", "method": "fransac", "seeds": accuracy.SEEDS, "f1": 0.99}
        ]
        (measured,) = self.claims(bars.before_bar, [], rows).values()
        self.assertEqual(measured, 0.99)

    def test_without_results_nothing_is_met(self):
        self.assertEqual({claim.verdict for claim in bars.claims(loaded([]))}, {"not measured"})


class Pages(unittest.TestCase):
    def test_blocks_are_rewritten_and_nothing_else(self):
        text = "before\n<!-- block: threads -->\nold\n<!-- end -->\n12 apples\n<!-- block: plot stages -->\n<!-- end -->\nafter\n"
        filled = page.fill(text, loaded([]), {"stages"})
        self.assertEqual(
            filled,
            text.replace("old", page.NOT_MEASURED).replace(
                "stages -->\n", "stages -->\n![Where the time goes, by stage](benchmark/stages.svg)\n"
            ),
        )
        self.assertEqual(page.fill(filled, loaded([]), {"stages"}), filled)

    def test_an_unknown_block_is_an_error(self):
        with self.assertRaises(KeyError):
            page.fill("<!-- block: fables -->\n<!-- end -->\n", loaded([]), set())

    def test_every_block_stands_without_results(self):
        for name, block in page.BLOCKS.items():
            self.assertTrue(block(loaded([])), name)

    def test_numbers(self):
        self.assertEqual(
            [page.significant(value) for value in (0.01234, 0.4, 12.0, 123.4, 1234.0, None)],
            ["0.0123", "0.400", "12.0", "123", "1,230", "–"],
        )

    def test_all_planes_beside_quoted_ones(self):
        planes = {"suite": "planes", "dataset": "tum", "matched_f1": 0.98, "instance_f1_50": 0.9, "weighted_iou": 0.95}
        text = page.BLOCKS["all planes"](
            loaded(
                [
                    raw_row("cells", "multi-plane", "fransac", "project", [0.3], **planes),
                    raw_row("floor-deproject", "floor", "floor", "native", [0.1], suite="planes"),
                ]
            )
        )
        self.assertIn("| **cells** | ours | 0.300 | 0.300 | 3.00 | 0.900 | – | 0.950 | 0.980 | – | 0.980 |", text)
        self.assertIn("| *CAPE* | *quoted* |", text)
        self.assertNotIn("floor-deproject |", text)

    def test_objects_beside_the_rivals(self):
        figures = {"object_f1_75": 0.8, "over_segmentation": 0.1, "under_segmentation": 0.0}
        text = page.BLOCKS["objects"](
            loaded(
                [
                    finds_objects("obstacles", 0.6, "a", object_f1_50=0.9, false_objects=1, **figures),
                    finds_objects("obstacles", 0.6, "b", object_f1_50=1.0, false_objects=2, **figures),
                    finds_objects("obstacles", 0.6, "no objects", false_objects=1),
                    finds_objects("pcl-clusters-native", 90.0, "a", object_f1_50=0.5, false_objects=0, **figures),
                    finds_objects("pcl-clusters-native", None, "b", note="found nothing", object_f1_50=0.0, false_objects=0, **figures),
                    finds_objects("pcl-clusters-native", 90.0, "no objects", false_objects=0),
                    raw_row("pcl-clusters-packaged", "objects", "pcl", "packaged", [], suite="objects", dataset="", note="not built"),
                    finds_objects("pcl-voxel-clusters-native", 9.0, "a", object_f1_50=1.0, false_objects=0, **figures),
                    finds_objects("floor-deproject", 0.1, "a"),
                ]
            )
        )
        self.assertIn("| pcl-voxel-clusters-native | native | 1 | 9.00 | 90.0 | – | – | – | – | – |", text)
        self.assertIn("| **obstacles** | ours | 3 | 0.600 | 6.00 | 0.950 | 0.800 | 0.100 | 0.000 | 4 |", text)
        self.assertIn("| pcl-clusters-native | native | 2 of 3 | 90.0 | 900 | 0.250 | 0.800 | 0.100 | 0.000 | 0 |", text)
        self.assertIn("- pcl-clusters-native: found nothing.\n- pcl-clusters-packaged: not built.", text)
        self.assertNotIn("floor-deproject |", text)

    def test_a_row_says_speed_accuracy_and_the_best_rival(self):
        found = loaded(
            [
                ours([0.4], f1=0.9),
                pcl([6.0], f1=0.8),
                pcl([24.0], build="packaged", f1=0.8),
                pcl([], method="ransac", note="failed its check"),
                floor("floor-deproject", [0.05]),
            ]
        )
        text = page.BLOCKS["segment"](found)
        self.assertIn(
            "| **fransac** | ours | 1 | 1 | 0.400 | 0.400 | 0.400 | 2,500 | 8.00 | **15.0× faster than pcl-fransac-native** | 0.900 | 0.900 | 0.9000 | 0.9000 |",
            text,
        )
        self.assertIn("60.0× slower than fransac", text)
        self.assertIn("- pcl-ransac-native: failed its check.", text)


class Committed(unittest.TestCase):
    def test_the_pages_are_what_the_results_give(self):
        docs = SOURCE / "docs"
        if not (docs / "benchmark" / "results.json").exists():
            self.skipTest("docs/benchmark/results.json is missing: nothing was measured yet")
        found = results.load(docs / "benchmark" / "results.json")
        drawn = {plot.stem for plot in (docs / "benchmark").glob("*.svg")}
        for name in ("docs/benchmark.md", "docs/reproduction.md", "README.md"):
            text = (SOURCE / name).read_text(encoding="utf-8")
            self.assertEqual(
                page.fill(text, found, drawn), text, f"{name}: run scripts/bench --page-only docs/benchmark/results.json"
            )


@unittest.skipUnless(HAS_MATPLOTLIB, "matplotlib is missing")
class Plots(unittest.TestCase):
    def test_every_plot_has_its_name_on_the_page(self):
        import plots

        self.assertEqual(list(plots.FIGURES), list(page.PLOTS))

    def test_labels_keep_apart_and_near(self):
        import plots

        self.assertEqual(plots.spread([0.0, 50.0, 100.0], 10.0), [0.0, 50.0, 100.0])
        self.assertEqual(plots.spread([20.0, 20.0, 20.0, 90.0], 10.0), [10.0, 20.0, 30.0, 90.0])
        placed = plots.spread([0.0, 1.0, 12.0, 13.0], 10.0)
        self.assertTrue(all(high - low >= 10.0 - 1e-9 for low, high in zip(placed, placed[1:])))
        self.assertAlmostEqual(sum(placed), 26.0)

    def test_the_same_results_give_the_same_bytes(self):
        import plots

        rows = [ours([0.4], f1=0.9), pcl([6.0], f1=0.8)]
        rows += [
            ours([ms], suite="resolution", scene=f"{width}", width=width, height=width) for width, ms in ((80, 0.01), (800, 0.5))
        ]
        with tempfile.TemporaryDirectory() as folder:
            first, second = pathlib.Path(folder) / "1", pathlib.Path(folder) / "2"
            self.assertEqual(plots.draw(loaded(rows), first), ["fps-by-scene", "accuracy-speed", "stages", "resolution"])
            plots.draw(loaded(rows), second)
            for file in first.iterdir():
                self.assertEqual(file.read_bytes(), (second / file.name).read_bytes(), file.name)
                self.assertNotIn(b"<dc:date>", file.read_bytes())


if __name__ == "__main__":
    unittest.main()
