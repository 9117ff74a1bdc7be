# SPDX-License-Identifier: Apache-2.0
"""scripts/fit-confidence: on planes whose weights are known, against a program that finds them, and on rendered frames with fransac.

Environment: FRANSAC_APP, the program.
"""

import json
import math
import os
import pathlib
import re
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest
import zlib

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCRIPT = ROOT / "scripts/fit-confidence"
CONSTANTS = ROOT / "src/planes/cells/constants.hpp"
PROGRAM = os.environ.get("FRANSAC_APP", str(ROOT / "build/release/apps/fransac/fransac"))
PLANES, WIDTH = 100, 40  # of a toy frame: a plane per row
FRAMES = 20

# Copies labels.png; its planes are those of toy.json in the frame's folder. Rendered frames are copies of the dataset TOY.
STAND_IN = f"""#!{sys.executable}
import json, os, pathlib, shutil, sys
if sys.argv[1] == "synth":
    assert sys.argv[3:7] == ["--scene", "all", "--noise", pathlib.Path(sys.argv[2]).name] and sys.argv[7:] == ["--frames", "3"], sys.argv
    shutil.copytree(os.environ["TOY"], sys.argv[2])
    sys.exit()
dataset, options = pathlib.Path(sys.argv[2]), dict(zip(sys.argv[3::2], sys.argv[4::2]))
assert sys.argv[1] == "segment" and (options["--method"], options["--min-confidence"]) == ("cells", "0"), sys.argv
for name in ("--labels", "--json"):
    os.makedirs(options[name])
for toy in dataset.glob("*/toy.json"):
    shutil.copy(toy.parent / "found.png", pathlib.Path(options["--labels"], toy.parent.name + ".png"))
    shutil.copy(toy, pathlib.Path(options["--json"], toy.parent.name + ".json"))
"""


def interpreter():
    """One that has numpy: this, or the system's."""
    for python in (sys.executable, "/usr/bin/python3"):
        try:
            if subprocess.run([python, "-c", "import numpy"], capture_output=True, check=False).returncode == 0:
                return python
        except OSError:
            pass
    return None


PYTHON = interpreter()


def png(path, rows, kind=0):
    """8-bit grey, with one of PNG's five filters."""

    def chunk(name, content):
        return struct.pack(">I", len(content)) + name + content + struct.pack(">I", zlib.crc32(name + content))

    def filtered(row, above):
        for i, value in enumerate(row):
            a, b, c = (row[i - 1] if i else 0), above[i], (above[i - 1] if i else 0)
            nearest = min((a, b, c), key=lambda x: abs(a + b - c - x))  # the first of equals, as PNG wants it
            yield (value - (0, a, b, (a + b) // 2, nearest)[kind]) & 255

    packed = b"".join(bytes([kind, *filtered(row, above)]) for row, above in zip(rows, [[0] * len(rows[0]), *rows]))
    header = struct.pack(">IIBBBBB", len(rows[0]), len(rows), 8, 0, 0, 0, 0)
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(packed)) + chunk(b"IEND", b""))


def plane(label, **evidence):
    """Its evidence adds nothing to the confidence but what is named."""
    return {"id": label, "confidence": 0.5,
            "evidence": {"share": 1.0, "turn_rad": 0.97, "turn_sigma_rad": 1.0, "smooth_border": 0.0, **evidence}}  # fmt: skip


def toy(folder, evidence, true):
    """FRAMES frames, of PLANES planes each; evidence(i) and true(i) of the i-th of all."""
    folder.mkdir(parents=True)
    (folder / "dataset.json").write_text('{"truth": "planes"}', encoding="utf-8")
    for f in range(FRAMES):
        frame = folder / f"frame{f:02}"
        frame.mkdir()
        first = f * PLANES
        # Some pixels of each row are of any label: what reads PNGs wrongly goes wrong from there on.
        noise = [[(31 * k + 77 * i * i) % 256 for i in range(5)] for k in range(PLANES)]
        truth = [noise[k] + [k + 1 if true(first + k) else 255] * (WIDTH - 5) for k in range(PLANES)]
        png(frame / "labels.png", truth, kind=f % 5)
        png(frame / "found.png", [noise[-k] + [PLANES - k] * (WIDTH - 5) for k in range(PLANES)], kind=(f + 1) % 5)
        found = [plane(PLANES - k, **evidence(first + k)) for k in range(PLANES)]
        (frame / "toy.json").write_text(json.dumps({"planes": found}), encoding="utf-8")
    return folder


def logit(p):
    return math.log(p / (1 - p))


@unittest.skipUnless(PYTHON, "numpy is missing")
class FitConfidence(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = pathlib.Path(temporary.name)
        self.stand_in = self.folder / "stand-in"
        self.stand_in.write_text(STAND_IN, encoding="utf-8")
        self.stand_in.chmod(0o755)
        self.constants = self.folder / "constants.hpp"
        shutil.copy(CONSTANTS, self.constants)
        self.page = self.folder / "page.md"
        self.page.write_text("before\n<!-- confidence -->\nold\n<!-- end -->\nafter\n", encoding="utf-8")

    def fit(self, *arguments, program=None):
        command = [PYTHON, "-B", SCRIPT, "--program", program or self.stand_in, "--constants", self.constants, "--page", self.page]
        environment = {**os.environ, "TOY": str(self.folder / "toy")}
        return subprocess.run([*map(str, command), *map(str, arguments)], capture_output=True, text=True, check=False, env=environment)

    def weights(self, done):
        self.assertEqual(done.returncode, 0, done.stderr)
        return {name: float(value) for name, value in re.findall(r"^\| `(\w+)` \| (-?[\d.]+) \|$", done.stdout, re.M)}

    def rows(self, done):
        return [[cell.strip() for cell in line.strip("|").split("|")] for line in done.stdout.splitlines() if line.startswith("|")]

    def two_kinds(self, name="toy"):
        """Of planes with no smooth border 9 of 10 are true, of planes with nothing else 2 of 10."""
        return toy(self.folder / name, lambda i: {"smooth_border": float(i // 10 % 2)}, lambda i: i % 10 < (2 if i // 10 % 2 else 9))

    def test_weights_are_the_log_odds_of_two_kinds(self):
        found = self.weights(self.fit(self.two_kinds(), "--synth", "0"))
        self.assertEqual({name: found[name] for name in ("share", "turn", "turn_sigma")}, {"share": 0, "turn": 0, "turn_sigma": 0})
        # Where the gradient is zero, of the log likelihood of 1000 planes of each kind less half the square of the penalised weight.
        without, only = (1 / (1 + math.exp(-x)) for x in (found["bias"], found["bias"] + found["smooth"]))
        self.assertAlmostEqual(1000 * (0.9 - without) + 1000 * (0.2 - only), 0, delta=0.2)
        self.assertAlmostEqual(1000 * (0.2 - only), found["smooth"], delta=0.2)

    def test_each_number_gets_its_own_weight(self):
        for name, value, expected in (
            ("share", math.exp(-2), 2), ("turn_rad", math.exp(2) - 0.03, -2), ("turn_sigma_rad", math.exp(-2), 2)
        ):  # fmt: skip
            # All of those without are true to 9 of 10, of those with to 2 of 10; the log of the value is 2 or -2.
            data = toy(self.folder / name, lambda i: {name: value} if i // 10 % 2 else {}, lambda i: i % 10 < (2 if i // 10 % 2 else 9))
            found = self.weights(self.fit(data, "--synth", "0"))
            key = name.replace("_rad", "")
            self.assertAlmostEqual(found[key], (logit(0.9) - logit(0.2)) / expected, delta=0.02)
            self.assertEqual([other for other in found if other != "bias" and abs(found[other]) > 1e-3], [key])

    def test_left_out(self):
        same = self.two_kinds("same")
        # Where it is the other way round, what was learnt from the others is wrong.
        other = toy(self.folder / "other", lambda i: {"smooth_border": float(i // 10 % 2)}, lambda i: (i % 10 < 9) == bool(i // 10 % 2))
        self.two_kinds()
        done = self.fit(same, other, "--synth", "3")
        rows = self.rows(done)
        begin = [row[0] for row in rows].index("left out")
        by_name = {row[0]: row[1:] for row in rows[begin + 2 : begin + 9]}
        rendered = [f"rendered: {sensor}" for sensor in ("none", "kinect1", "stereo", "tof")]
        self.assertEqual(list(by_name), ["same", "other", "all of these", *rendered])
        self.assertEqual(by_name["same"][:3], ["2000", "1100", "0.850"])
        self.assertEqual(by_name["other"][:3], ["2000", "1000", "0.100"])
        self.assertEqual(by_name["all of these"][:3], ["4000", "2100", "0.475"])
        # All rendered frames are left out at once: one sensor's would tell all of the next one's.
        for name in rendered:
            self.assertEqual(by_name[name][:2], ["2000", "1100"])
            self.assertLess(float(by_name[name][2]), 0.6)

    def test_what_counts(self):
        """Planes that the truth leaves open, and small ones, are left out; an IoU of just under a half is false."""
        frame = toy(self.folder / "toy", lambda i: {}, lambda i: True) / "frame00"
        for other in range(1, FRAMES):
            shutil.rmtree(self.folder / f"toy/frame{other:02}")

        def found(planes):  # (label in the truth, pixels of the truth, pixels found)
            truth = [[label] * pixels + [255] * (WIDTH * 5 - pixels) for label, pixels, _ in planes]
            labels = [[k + 1] * pixels + [255] * (WIDTH * 5 - pixels) for k, (_, _, pixels) in enumerate(planes)]
            png(frame / "labels.png", truth)
            png(frame / "found.png", labels)
            (frame / "toy.json").write_text(json.dumps({"planes": [plane(k + 1) for k in range(len(planes))]}), encoding="utf-8")
            rows = self.rows(self.fit(frame.parent, "--synth", "3"))
            return [row[1:3] for row in rows if row[0] == "toy"][0] if rows else None

        two = [(1, 100, 100), (255, 100, 100)]  # one true, one false
        self.assertEqual(found(two), ["2", "1"])
        self.assertEqual(found([*two, (2, 100, 50)]), ["3", "2"])
        self.assertEqual(found([*two, (2, 100, 49)]), ["3", "1"])
        self.assertEqual(found([*two, (2, 50, 101)]), ["3", "1"])
        self.assertEqual(found([*two, (0, 100, 100)]), ["2", "1"])
        self.assertEqual(found([*two, (2, 2, 2)]), ["2", "1"])

    def test_writes_constants_and_page(self):
        before = self.constants.read_text(encoding="utf-8")
        data = [self.two_kinds(), self.two_kinds("second")]
        self.fit(*data, "--synth", "0")
        self.assertEqual(self.constants.read_text(encoding="utf-8"), before)
        done = self.fit(*data, "--synth", "0", "--write")
        weights = self.weights(done)
        after = self.constants.read_text(encoding="utf-8")
        self.assertEqual({name: float(value) for name, value in re.findall(r"^  double (\w+) = (.*);$", after, re.M)}, weights)
        numbers = re.compile(r"^(  double \w+ = ).*;$", re.M)
        self.assertEqual(numbers.sub(r"\1", after), numbers.sub(r"\1", before))
        tables = done.stdout[done.stdout.index("| left out") :]
        self.assertEqual(self.page.read_text(encoding="utf-8"), f"before\n<!-- confidence -->\n{tables}<!-- end -->\nafter\n")

    def test_what_cannot_be_fitted(self):
        good = self.two_kinds()
        dominant = toy(self.folder / "dominant", lambda i: {}, lambda i: True)
        (dominant / "dataset.json").write_text('{"truth": "dominant"}', encoding="utf-8")
        empty = self.folder / "empty"
        empty.mkdir()
        (empty / "dataset.json").write_text('{"truth": "planes"}', encoding="utf-8")
        all_true = toy(self.folder / "all_true", lambda i: {}, lambda i: True)
        broken = self.two_kinds("broken")
        (broken / "frame00/labels.png").write_bytes(b"no picture")
        old = self.two_kinds("old")
        (old / "frame00/toy.json").write_text('{"planes": [{"id": 1, "confidence": 1.0}]}', encoding="utf-8")
        other = self.folder / "other.hpp"
        other.write_text("struct Confidence {\n  double bias = 1.0;\n};\n", encoding="utf-8")
        for arguments, message in [
            ([], "no datasets"),
            (["/nowhere"], "/nowhere: no dataset.json"),
            ([dominant], "its truth is 'dominant'"),
            ([empty], "no frame has a labels.png"),
            ([all_true], "are true: nothing to tell apart"),
            ([broken], "frame00/labels.png: not a PNG of 8-bit grey"),
            ([old], "old/frame00: no planes with evidence"),
            ([good, self.two_kinds("there/toy")], "two datasets are called toy"),
            ([good, "--program", "/nowhere"], "/nowhere: No such file"),
            ([good, "--program", "false"], "false segment "),
            ([good, "--constants", other], "other.hpp: no struct Confidence of bias, share, turn, turn_sigma, smooth"),
            ([good, "--constants", "/nowhere"], "/nowhere: No such file"),
            ([good, "--write", "--page", other], "other.hpp: has no place for the tables"),
            ([good, "--synth", "-1"], "'-1' is not a whole number"),
            ([good, "--jobs", "0"], "not a positive"),
        ]:
            done = self.fit("--synth", "0", *arguments)
            self.assertEqual(done.returncode, 2, (arguments, done.stdout))
            self.assertIn(message, done.stderr)
            self.assertNotIn("Traceback", done.stderr)

    def test_the_program_has_the_formula(self):
        data = self.folder / "rendered"
        command = [PROGRAM, "synth", data, "--scene", "all", "--width", "160", "--height", "120"]
        subprocess.run([str(word) for word in command], check=True)
        done = self.fit(data, "--synth", "0", "--check", program=PROGRAM)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertGreater(int(done.stdout.split()[0]), 20)
        # Weights fitted to these frames are others.
        self.weights(self.fit(data, "--synth", "0", "--write", program=PROGRAM))
        done = self.fit(data, "--synth", "0", "--check", program=PROGRAM)
        self.assertEqual(done.returncode, 2, done.stdout)
        self.assertIn("the program's confidence is not that of", done.stderr)


if __name__ == "__main__":
    unittest.main()
