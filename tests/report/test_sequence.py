#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A sequence has a page of its own that shows what `fransac track` finds, of a size that does not grow with its length."""

import collections
import json
import pathlib
import re
import shutil
import statistics
import subprocess
import tempfile
import unittest
from base64 import b64decode

import pages
from pages import parse, text, with_class

FRAMES = 30
THUMBNAILS = 24
ROWS = 40
LARGE = 100  # pixels of a plane that cannot be overlooked
BORDERS = 6  # pixels of such a plane that have its full colour at least


def sequence_pages(index):
    return sorted(path for path in index.parent.iterdir() if path.name.startswith("sequence"))


def by_id(root, name):
    found = [element for element in root.iter() if element.get("id") == name]
    assert len(found) == 1, f"{len(found)} elements {name}"
    return found[0]


def lines_of(folder, *arguments):
    return [json.loads(line) for line in pages.fransac(folder, "track", *arguments).splitlines()]


def seen(lines, kind):
    """What lines tell of each id, frame by frame."""
    found = collections.defaultdict(list)
    for line in lines:
        for thing in line[kind]:
            found[thing["id"]].append((line["frame"], thing))
    return found


def columns_of(row):
    """Places of a bar's columns."""
    places = []
    for path in row.iter("path"):
        for begin, length in re.findall(r"M(\d+) 0h(\d+)v1h-\2z", path.get("d")):
            places += range(int(begin), int(begin) + int(length))
    return sorted(places)


def colour_of(row):
    return tuple(map(int, re.search(r"rgb\((\d+),(\d+),(\d+)\)", with_class(row, "swatch")[0].get("style")).groups()))


def colours_of(image, labels):
    """How many pixels have which label and which colour; both are of the same size."""
    pictures = [b64decode(image.get("src").partition(",")[2]), labels.read_bytes()]
    colours, numbers = ([pixel for row in pages.pixels(picture) for pixel in row] for picture in pictures)
    assert len(colours) == len(numbers)
    return collections.Counter((label, colour) for (label,), colour in zip(numbers, colours))


def repeated(folder, name, frames, other=None):
    """A sequence of one image, and of another for some of the frames."""
    pathlib.Path(folder, name, "depth").mkdir(parents=True)
    shutil.copy(pathlib.Path(folder, "scenes", "desk_3_0", "depth.png"), pathlib.Path(folder, name, "depth", "0.png"))
    shutil.copy(pathlib.Path(folder, "scenes", "desk_3_0", "camera.json"), pathlib.Path(folder, name, "camera.json"))
    entries = [f"{i / 30:.4f} depth/{(other or {}).get(i, '0.png')}\n" for i in range(frames)]
    pathlib.Path(folder, name, "depth.txt").write_text("".join(entries), encoding="utf-8")


class Walk(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.mkdtemp(prefix="fransac_sequence_")
        cls.addClassCleanup(shutil.rmtree, cls.folder, ignore_errors=True)
        pages.walk(cls.folder, scene="desk", frames=FRAMES)
        cls.index = pages.report(cls.folder, "walk", "--method", "cells", "--obstacles", "--threads", "2")
        cls.file = sequence_pages(cls.index)[0]
        cls.page = parse(cls.file)
        cls.lines = lines_of(cls.folder, "walk", "--obstacles")

    def test_the_first_page_leads_to_it_and_back(self):
        self.assertEqual([path.name for path in sequence_pages(self.index)], ["sequence1-walk.html"])
        index = parse(self.index)
        link = with_class(index, "sequence")[0]
        self.assertEqual(link.find("a").get("href"), self.file.name)
        self.assertIn(f"{FRAMES} frames in 1.0 s", text(link))
        self.assertIn(f"compared on {THUMBNAILS} of its frames", text(link))
        scenes = with_class(index, "scene")
        self.assertEqual(len(scenes), THUMBNAILS)
        self.assertEqual([text(scenes[i].find("summary")).split()[0] for i in (0, -1)], ["0.000000", "0.966667"])
        self.assertEqual(self.page.find(".//nav/a").get("href"), "index.html")

    def test_stands_on_its_own(self):
        source = self.file.read_text(encoding="utf-8")
        self.assertTrue(source.startswith("<!DOCTYPE html>"))
        self.assertNotRegex(source, r"https?://|<script|<link|@import|url\(")
        self.assertTrue(all(image.get("alt") for image in self.page.iter("img")))
        self.assertTrue(all(svg.get("aria-label") and text(svg.find("title")) for svg in self.page.iter("svg")))

    def test_rows_say_what_track_says(self):
        for kind in ("planes", "objects"):
            found = seen(self.lines, kind)
            rows = by_id(self.page, kind).findall("./tbody/tr")
            self.assertEqual(len(rows), min(ROWS, len(found)))
            for row in rows:
                identity, _, frames, is_what, size = (text(cell) for cell in row)
                with self.subTest(kind=kind, id=identity):
                    own = found[int(identity)]
                    self.assertEqual(columns_of(row), [frame for frame, _ in own])
                    self.assertEqual(int(frames), len(own))
                    counts = collections.Counter(thing["kind"] for _, thing in own)
                    self.assertEqual(counts[is_what], max(counts.values()))
                    if kind == "planes":
                        self.assertAlmostEqual(float(size), statistics.mean(thing["area_m2"] for _, thing in own), delta=6e-4)
                    else:
                        for axis, part in enumerate(size.split(" × ")):
                            mean = statistics.mean(thing["box"]["size"][axis] for _, thing in own)
                            self.assertAlmostEqual(float(part), mean, delta=6e-3)

    def test_a_plane_has_its_colour_in_every_thumbnail(self):
        colours = {int(text(row[0])): colour_of(row) for row in by_id(self.page, "planes").findall("./tbody/tr")}
        images = list(with_class(by_id(self.page, "planes-section"), "thumbnails")[0].iter("img"))
        self.assertEqual(len(images), THUMBNAILS)
        chosen = [i * (FRAMES - 1) // (THUMBNAILS - 1) for i in range(THUMBNAILS)]
        labels = {(plane["id"], plane["label"]) for line in self.lines for plane in line["planes"] if plane["inliers"] >= LARGE}
        self.assertGreater(len(labels), len({identity for identity, _ in labels}), "all planes have one label: nothing is tested")
        pages.fransac(self.folder, "segment", "walk", "--labels", "labels")
        pictures = sorted(pathlib.Path(self.folder, "labels").iterdir())
        self.assertEqual(len(pictures), FRAMES)
        for frame, image in zip(chosen, images):
            self.assertEqual(image.get("alt"), f"Planes of frame {frame}")
            drawn = colours_of(image, pictures[frame])
            for plane in self.lines[frame]["planes"]:
                for identity, colour in colours.items():
                    pixels = drawn[plane["label"], colour]
                    if identity != plane["id"]:
                        self.assertEqual(pixels, 0, f"frame {frame} shows plane {plane['id']} as {identity}")
                    elif plane["inliers"] >= LARGE:
                        self.assertGreater(pixels, BORDERS, f"frame {frame}, plane {identity}")

    def test_every_frame_is_in_the_histogram(self):
        plot, path = with_class(self.page, "plots")[0].iter("svg")
        counts = [re.search(r"milliseconds: (\d+) frames", text(bar)) for bar in plot.iter("rect")]
        self.assertEqual(sum(int(count.group(1)) for count in counts), FRAMES)
        words = [text(word) for word in plot.iter("text")]
        self.assertLessEqual({"milliseconds", "frames"}, set(words))
        for mark in ("median", "p99"):
            shown = next(word for word in words if word.startswith(mark))
            self.assertIn(f"{shown} ms", text(by_id(self.page, "times")))
        self.assertIn("ahead [m]", [text(word) for word in path.iter("text")])

    def test_the_path_ends_where_track_says(self):
        _, path = with_class(self.page, "plots")[0].iter("svg")
        told = next(text(mark) for mark in path.iter("path") if text(mark).startswith("end: "))
        right, ahead = map(float, re.findall(r"-?\d+\.\d+", told))
        x, y, z = self.lines[-1]["pose"]["translation"]
        self.assertAlmostEqual(right, x, delta=0.03)  # the camera is tilted, but hardly rolled
        self.assertLessEqual(abs(ahead) ** 2, y * y + z * z + 0.01)


class Sequences(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.mkdtemp(prefix="fransac_sequence_")
        self.addCleanup(shutil.rmtree, self.folder)
        pages.synth(self.folder, frames=1)

    def report(self, *arguments):
        return pages.report(self.folder, *arguments, "--method", "cells", "--pictures", "0")

    def test_the_length_does_not_make_the_page_larger(self):
        sizes = []
        for frames in (60, 600):
            repeated(self.folder, f"of{frames}", frames)
            index = self.report(f"of{frames}", "--obstacles")
            page = sequence_pages(index)[0]
            sizes.append(index.stat().st_size + page.stat().st_size)
            page.unlink()
            self.assertEqual(len(with_class(parse(index), "scene")), THUMBNAILS)
        self.assertLess(sizes[1], 1.05 * sizes[0])
        self.assertLess(sizes[1], 3e6)

    def test_columns_stand_for_several_frames(self):
        repeated(self.folder, "of400", 400, {7: "missing.png"})
        row = by_id(parse(sequence_pages(self.report("of400"))[0]), "planes").find("./tbody/tr")
        self.assertEqual(row.find(".//svg").get("viewBox"), "0 0 200 1")
        self.assertEqual(columns_of(row), list(range(200)))
        pale = [path for path in row.iter("path") if path.get("class") == "pale"]
        self.assertEqual([path.get("d") for path in pale], ["M3 0h1v1h-1z"])  # frames 6 and 7

    def test_a_broken_frame_is_skipped_and_named(self):
        repeated(self.folder, "broken", 30, {7: "<b>&'.png"})
        pathlib.Path(self.folder, "broken", "depth", "<b>&'.png").write_text("no picture", encoding="utf-8")
        index = self.report("broken")
        root = parse(sequence_pages(index)[0])
        self.assertIn("<b>&'.png", text(with_class(root, "skipped")[0]))
        self.assertNotIn(7, columns_of(by_id(root, "planes").find("./tbody/tr")))
        frames = [image.get("alt") for image in with_class(root, "thumbnails")[0].iter("img")]
        self.assertEqual(len(frames), THUMBNAILS - 1)  # in its place stands the next one, which would have a picture anyway
        self.assertNotIn("Planes of frame 7", frames)
        self.assertEqual(len(with_class(parse(index), "scene")), THUMBNAILS)

    def test_names_are_text_and_files_are_apart(self):
        hostile = "<script>alert('1')&\n"
        repeated(self.folder, hostile, 3)
        repeated(self.folder, "a/index", 3)
        repeated(self.folder, "b/index", 3)
        index = self.report(hostile, "a/index", "b/index")
        files = sequence_pages(index)
        self.assertEqual([path.name for path in files],
                         ["sequence1-_script_alert__1____.html", "sequence2-index.html", "sequence3-index.html"])
        root = parse(files[0])
        self.assertEqual(list(root.iter("script")), [])
        self.assertEqual(text(root.find(".//h1")), hostile.strip())
        links = [link.find("a").get("href") for link in with_class(parse(index), "sequence")]
        self.assertEqual(links, [path.name for path in files])

    def test_scenes_have_no_page_of_their_own(self):
        pages.synth(self.folder, name="many", frames=3)
        repeated(self.folder, "single", 1)
        index = self.report("many", "single")
        self.assertEqual([path.name for path in index.parent.iterdir()], ["index.html"])
        self.assertEqual(with_class(parse(index), "sequence"), [])

    def test_a_page_that_cannot_be_written_stops_it_before_anything_is_done(self):
        repeated(self.folder, "walk", 3)
        pathlib.Path(self.folder, "page", "sequence1-walk.html").mkdir(parents=True)
        with self.assertRaises(subprocess.CalledProcessError) as failed:
            self.report("walk")
        self.assertIn("--out: 'page/sequence1-walk.html' is a folder", failed.exception.stderr)
        self.assertEqual(len(list(pathlib.Path(self.folder, "page").iterdir())), 1)


if __name__ == "__main__":
    unittest.main()
