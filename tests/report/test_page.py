#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The page stands on its own, is well-formed, and shows the numbers that `fransac evaluate` gives."""

import json
import pathlib
import re
import shutil
import struct
import tempfile
import unittest
import xml.etree.ElementTree as xml
from base64 import b64decode

import pages
from pages import parse, text, with_class

TIMES = ("fps", "median_ms")


def cells(table):
    """The heads of the columns, and the rows with their heads."""
    heads = [text(head) for head in table.findall("./thead/tr/th")]
    return heads, [[text(cell) for cell in row] for row in table.findall("./tbody/tr")]


def decimals(value):
    return len(value.partition(".")[2])


class Page(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.mkdtemp(prefix="fransac_report_")
        self.addCleanup(shutil.rmtree, self.folder)
        pages.synth(self.folder)

    def page(self, *arguments, datasets=("scenes",)):
        return parse(pages.report(self.folder, *datasets, *arguments))

    def evaluate(self, *arguments):
        return json.loads(pages.fransac(self.folder, "evaluate", "scenes", "--repeat", "1", "--json", "-", "--method",
                                        ",".join(pages.METHODS), *arguments))

    def assert_equal_numbers(self, shown, row, key):
        value = row.get(key)
        if value is None:
            self.assertEqual(shown, "-", key)
        else:
            self.assertEqual(shown, f"{value:.{decimals(shown)}f}", key)

    def test_stands_on_its_own(self):
        path = pages.report(self.folder, "scenes")
        source = path.read_text(encoding="utf-8")
        self.assertTrue(source.startswith("<!DOCTYPE html>"))
        self.assertNotRegex(source, r"https?://|<script|<link|@import|url\(")
        root = parse(path)
        images = list(root.iter("img"))
        self.assertEqual(len(images), 2 * (4 + 5 + 5))  # colour, depth, cloud, truth; planes and differences by five methods
        for image in images:
            with self.subTest(image.get("alt")):
                self.assertTrue(image.get("alt"))
                kind, _, data = image.get("src").partition(",")
                self.assertEqual(kind, "data:image/png;base64")
                png = b64decode(data, validate=True)
                self.assertEqual(png[:8], b"\x89PNG\r\n\x1a\n")
                self.assertEqual(struct.unpack(">II", png[16:24]), (int(image.get("width")), int(image.get("height"))))
        for link in root.iter("a"):
            self.assertEqual(len([e for e in root.iter() if e.get("id") == link.get("href")[1:]]), 1)
        for head in root.iter("th"):
            self.assertIn(head.get("scope"), ("row", "col"))
        self.assertEqual([path.name], [p.name for p in path.parent.iterdir()])

    def test_one_section_per_scene(self):
        scenes = with_class(self.page(), "scene")
        self.assertEqual([text(s.find("summary")).split()[0] for s in scenes], ["desk_3_0", "desk_3_1"])
        self.assertEqual(len({s.get("id") for s in scenes}), 2)

    def test_scene_tables_hold_what_evaluate_gives(self):
        root = self.page("--planes", "all")
        result = self.evaluate("--planes", "all")
        tables = {t.get("data-quantity"): t for t in root.iter("table") if t.get("data-quantity")}
        self.assertLessEqual({"precision", "recall", "f1", "fps", "median_ms", "instance_f1_50", "weighted_iou"}, set(tables))
        for key, table in tables.items():
            heads, rows = cells(table)
            self.assertEqual(heads, ["scene", *pages.METHODS])
            self.assertEqual([row[0] for row in rows], ["desk_3_0", "desk_3_1", "mean"])
            for name, *values in rows:
                for method, value in zip(pages.METHODS, values):
                    source = result["mean"] if name == "mean" else [r for r in result["scenes"] if r["scene"] == name]
                    row = next(r for r in source if r["method"] == method)
                    if key in TIMES:
                        self.assertGreater(float(value), 0)
                    else:
                        self.assert_equal_numbers(value, row, key)

    def test_mean_table_holds_what_evaluate_gives(self):
        heads, rows = cells(with_class(self.page(), "of-means")[0])
        keys = {"precision": "precision", "recall": "recall", "F1": "f1", "best F1": "best_f1", "matched": "matched_f1",
                "F1@0.5": "instance_f1_50", "F1@0.75": "instance_f1_75", "wIoU": "weighted_iou",
                "angle [deg]": "angle_deg", "offset [m]": "offset_m", "planes": "planes", "median [ms]": "median_ms", "fps": "fps"}
        self.assertEqual(heads[1:], list(keys))
        for shown, row in zip(rows, self.evaluate()["mean"], strict=True):
            self.assertEqual(shown[0], row["method"])
            for head, value in zip(heads[1:], shown[1:]):
                if keys[head] not in TIMES:
                    self.assert_equal_numbers(value, row, keys[head])

    def test_plots(self):
        plots = with_class(self.page(), "plots")[0]
        titles = [text(svg.find("title")) for svg in plots.iter("svg")]
        self.assertEqual(titles, ["Frames per second, scene by scene", "Precision, recall and F1", "Accuracy against speed",
                                  "Time by stage"])
        marks = [path for path in plots[0].iter("path") if path.find("title") is not None and ": " in text(path)]
        self.assertEqual(len(marks), 2 * 5)
        bars = [text(bar) for bar in plots[1].iter("rect") if ", " in text(bar)]
        self.assertEqual(len(bars), 3 * 5)
        recall = next(row for row in self.evaluate()["mean"] if row["method"] == "fransac")["recall"]
        self.assertIn(f"fransac, recall: {recall:.4f}", bars)

    def with_regions(self):
        """Gives the first scene regions: its true planes, numbered as in a gt_seg.png."""
        scene = pathlib.Path(self.folder, "scenes", "desk_3_0")
        labels = [value for row in pages.pixels((scene / "labels.png").read_bytes()) for (value,) in row]
        pages.write_grey(scene / "gt_seg.png", 160, 120, bytes(v + 9 if 0 < v < 255 else 0 for v in labels))

    def curves(self, root):
        """Of each curve plot the values that its marks tell, by method and tolerance."""
        plots = [svg for svg in root.iter("svg") if "over tolerance" in text(svg.find("title"))]
        found = {}
        for svg in plots:
            marks = [text(path) for path in svg.iter("path") if path.find("title") is not None and ", " in text(path)]
            found[text(svg.find("title"))] = {
                (m[1], m[2]): m[3] for m in (re.fullmatch(r"(\S+), tolerance (0\.\d\d): ([\d.]+)", mark) for mark in marks)}
        return found

    def test_curves_over_tolerances(self):
        """First of the scene that has regions alone, then of both: of the other its planes."""
        for prepare, arguments in ((self.with_regions, ()), (lambda: None, ("--hoover", "0.7"))):
            prepare()
            methods = ("cells", "fransac")
            curves = self.curves(self.page("--planes", "all", "--method", ",".join(methods), *arguments))
            self.assertEqual(list(curves), ["Correct regions over tolerance", "Noise regions over tolerance"])
            for curve in curves.values():
                self.assertEqual(set(curve), {(m, f"0.{t}") for m in methods for t in range(51, 96)})
            for tolerance in ("0.51", "0.8", "0.95"):
                result = json.loads(pages.fransac(self.folder, "evaluate", "scenes/desk_3_0" if not arguments else "scenes", "--method",
                                                  ",".join(methods), "--planes", "all", "--repeat", "1", "--hoover", tolerance, "--json", "-"))
                for row in result["mean"]:
                    key = (row["method"], f"{float(tolerance):.2f}")
                    self.assertEqual(curves["Correct regions over tolerance"][key], f"{row['hoover']['correct']:.2f}")
                    self.assertEqual(curves["Noise regions over tolerance"][key], f"{row['hoover']['noise']:.2f}")

    def test_no_curves_without_regions_unless_asked(self):
        self.assertEqual(self.curves(self.page("--planes", "all", "--method", "cells")), {})
        self.with_regions()
        self.assertEqual(self.curves(self.page("--method", "fransac")), {}, "one plane was asked for")

    def test_every_plane_of_cells_is_listed(self):
        tables = with_class(self.page("--method", "cells,fransac"), "of-planes")
        self.assertEqual(len(tables), 2)  # one per scene, none of fransac
        for name, table in zip(("desk_3_0", "desk_3_1"), tables):
            found = json.loads(pages.fransac(self.folder, "segment", f"scenes/{name}", "--method", "cells", "--json", "-"))
            self.assertEqual(text(table.find("caption")), f"Planes of cells in {name}, up {found['up_source']}")
            self.assertGreater(len(found["planes"]), 1)
            _, rows = cells(table)
            shown = [(f"{p['id']}", p["kind"], f"{p['area_m2']:.3f}", f"{1e3 * p['rms_m']:.1f}", f"{p['confidence']:.2f}", f"{p['inliers']}")
                     for p in found["planes"]]
            self.assertEqual([tuple(row[:6]) for row in rows], shown)
            colours = [swatch.get("style") for swatch in with_class(table, "swatch")]
            self.assertEqual(len(set(colours)), len(rows), "every plane has a colour of its own")

    def test_what_does_not_apply_is_left_out(self):
        self.assertIn("one plane per scene; --planes all", text(self.page()))
        self.assertIn("one plane per scene was asked for", text(self.page("--method", "fransac")))
        self.assertNotIn("--planes all", text(self.page("--method", "cells")))
        pages.change_truth(self.folder, "dominant")
        root = self.page("--planes", "all")
        self.assertIn("dominant plane alone", text(root))
        self.assertNotIn("instance_f1_50", [t.get("data-quantity") for t in root.iter("table")])
        pages.change_truth(self.folder, "none")
        root = self.page()
        self.assertIn("has no truth", text(root))
        self.assertEqual({t.get("data-quantity") for t in root.iter("table")} - {None}, set(TIMES))
        self.assertEqual(len(list(root.iter("img"))), 2 * (3 + 5))
        self.assertEqual(len(list(root.iter("svg"))), 2)
        self.assertEqual(with_class(root, "legend"), [])

    def test_names_from_files_are_text(self):
        scenes = pathlib.Path(self.folder, "scenes")
        hostile = "<script>alert('1')<!-- & \"x\"]]>"
        (scenes / "desk_3_0").rename(scenes / hostile.replace("/", ""))
        (scenes / "dataset.json").write_text(json.dumps({"truth": "planes", "sensor": "<b>&"}), encoding="utf-8")
        scenes.rename(scenes.parent / "<i>&amp;\n")
        root = self.page(datasets=("<i>&amp;\n",))
        self.assertEqual(list(root.iter("script")), [])
        self.assertIn(hostile, " ".join(text(s.find("summary")) for s in with_class(root, "scene")))
        self.assertIn("<b>&", text(root))
        self.assertEqual(text(root.find(".//h2")), "<i>&amp;")

    def test_a_name_that_is_no_utf8(self):
        scenes = pathlib.Path(self.folder, "scenes")
        (scenes / "desk_3_0").rename(scenes.joinpath(b"\xff\x01name".decode("utf-8", "surrogateescape")))
        self.assertIn("\ufffd\ufffdname", text(self.page("--method", "fransac")))

    def test_the_same_again_but_for_times(self):
        def timeless():
            source = pages.report(self.folder, "scenes").read_text(encoding="utf-8")
            source = re.sub(r"<svg.*?</svg>|<small>.*?</small>", "", source, flags=re.S)
            root = xml.fromstring(source)
            for table in root.iter("table"):
                times = [i for i, head in enumerate(table.findall("./thead/tr/th")) if text(head) in ("fps", "median [ms]")]
                if table.get("data-quantity") in TIMES:
                    table.clear()
                for row in table.iter("tr"):
                    for i in times:
                        row[i].clear()
            for cell in root.iter("td"):
                cell.attrib.pop("class", None)
            return xml.tostring(root)
        self.assertEqual(timeless(), timeless())

    def test_pictures(self):
        unfolded = with_class(self.page("--pictures", "1"), "scene")
        self.assertEqual([scene.get("open") for scene in unfolded], ["open", None])
        both = parse(pages.report(self.folder, "scenes", "scenes/desk_3_0"))
        self.assertEqual(len(with_class(both, "dataset")), 2)


if __name__ == "__main__":
    unittest.main()
