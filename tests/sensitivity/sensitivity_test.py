# SPDX-License-Identifier: Apache-2.0
"""scripts/sensitivity against a program that answers as a tunable fransac does."""

import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

SCRIPT = pathlib.Path(__file__).resolve().parents[2] / "scripts/sensitivity"

# F1@0.5 is 0.9, less 0.1 when `grow` is multiplied by 0.9, in the mean of two scenes; in dataset "other" it is half of that and falls by
# 0.01 when `seed` is multiplied by 1.1. A dataset "bad" is none.
STAND_IN = f"""#!{sys.executable}
import json, os, sys
if sys.argv[1:] == ["--list-constants"]:
    print("seed\\ngrow")
    sys.exit()
assert sys.argv[1] == "evaluate" and "cells" in sys.argv, sys.argv
if "bad" in sys.argv:
    sys.exit("bad: is no dataset")
tune = os.environ.get("FRANSAC_CELLS_TUNE", "")
scenes = []
for dataset in sys.argv[2 : sys.argv.index("--method")]:
    f1 = 0.8 if tune == "grow=0.9" else 0.9
    if os.path.basename(os.path.normpath(dataset)) == "other":
        f1 = 0.5 * f1 - (0.01 if tune == "seed=1.1" else 0)
    scene = {{"dataset": dataset, "instance_f1_75": 0.5, "weighted_iou": 0.9, "matched_f1": 0.99, "plane_pixel_f1": 0.98}}
    scenes += [{{**scene, "instance_f1_50": f1 - 0.05}}, {{**scene, "instance_f1_50": f1 + 0.05}}]
print(json.dumps({{"scenes": scenes}}))
"""


class Sensitivity(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.program = pathlib.Path(folder.name) / "fransac"
        self.program.write_text(STAND_IN, encoding="utf-8")
        self.program.chmod(0o755)

    def run_script(self, *arguments):
        command = [sys.executable, "-B", str(SCRIPT), "--program", str(self.program), *arguments]
        # The caller's own setting must not leak into the first run.
        environment = {**os.environ, "FRANSAC_CELLS_TUNE": "grow=0.9"}
        return subprocess.run(command, capture_output=True, text=True, check=False, env=environment)

    def test_one_row_per_constant_and_factor(self):
        done = self.run_script("data", "--json", "-")
        self.assertEqual(done.returncode, 0, done.stderr)
        rows = json.loads(done.stdout)["rows"]
        self.assertEqual(
            [(row["constant"], row["factor"]) for row in rows],
            [(None, 1.0), ("seed", 0.9), ("seed", 1.1), ("grow", 0.9), ("grow", 1.1)],
        )
        for row, f1 in zip(rows, [0.9, 0.9, 0.9, 0.8, 0.9], strict=True):
            self.assertAlmostEqual(row["instance_f1_50"], f1)

    def test_marks_the_worst_where_values_differ(self):
        lines = self.run_script("data").stdout.splitlines()
        self.assertRegex(lines[0], r"^constant +factor +F1@0.5 +F1@0.75 +wIoU +matched +plane px F1$")
        self.assertEqual([line.split()[2] for line in lines[1:]], ["0.9000", "0.9000", "0.9000", "0.8000*", "0.9000"])
        self.assertEqual("\n".join(lines).count("*"), 1)

    def test_bound(self):
        self.assertEqual(self.run_script("data", "--min", "0.79").returncode, 0)
        done = self.run_script("data", "--min", "0.84")
        self.assertEqual(done.returncode, 1)
        self.assertEqual(done.stderr, "sensitivity: grow x 0.9: F1@0.5 0.8000 is under 0.84\n")
        self.assertEqual(self.run_script("data", "--min", "0.84", "--only", "seed").returncode, 0)
        self.assertEqual(self.run_script("data", "--min", "0.84", "--factors", "0.95,1.1", "--jobs", "2").returncode, 0)

    def test_bounds_of_each_dataset(self):
        both = ("data", "some/other/")
        done = self.run_script(*both, "--min", "data=0.84", "--min", "other=0.43", "--fall", "data=0.1", "--fall", "other=0.02")
        self.assertEqual(done.returncode, 1)
        self.assertEqual(
            done.stderr.splitlines(),
            [
                "sensitivity: grow x 0.9: data: F1@0.5 0.8000 is under 0.84",
                "sensitivity: grow x 0.9: other: F1@0.5 0.4000 is under 0.43",
                "sensitivity: grow x 0.9: other: F1@0.5 falls by 0.0500, more than 0.02",
            ],
        )
        done = self.run_script(*both, "--fall", "other=0.009", "--only", "seed")
        self.assertEqual((done.returncode, done.stderr), (1, "sensitivity: seed x 1.1: other: F1@0.5 falls by 0.0100, more than 0.009\n"))
        self.assertEqual(self.run_script(*both, "--fall", "other=0.01", "--only", "seed").returncode, 0)
        done = self.run_script(*both, "--fall", "0.07")
        self.assertEqual(done.stderr, "sensitivity: grow x 0.9: F1@0.5 falls by 0.0750, more than 0.07\n")

    def test_the_worst_of_each_constant(self):
        self.assertEqual(
            self.run_script("data", "other", "--markdown").stdout.splitlines(),
            [
                "| constant | data: F1@0.5 | data: wIoU | other: F1@0.5 | other: wIoU |",
                "| --- | ---: | ---: | ---: | ---: |",
                "| as they are | 0.9000 | 0.9000 | 0.4500 | 0.9000 |",
                "| `seed` | 0 | 0 | -0.0100 (x 1.1) | 0 |",
                "| `grow` | -0.1000 (x 0.9) | 0 | -0.0500 (x 0.9) | 0 |",
            ],
        )

    def test_what_cannot_be_measured(self):
        for arguments, message in [
            (["bad"], "bad: is no dataset"),
            (["data", "--only", "moon"], "no constant 'moon'"),
            (["data", "--program", "/nowhere"], "FRANSAC_TUNABLE"),
            (["data", "--factors", "0"], "'0' is not a positive number"),
            (["data", "--min", "2"], "'2' is not between 0 and 1"),
            (["data", "--min", "data=x"], "--min"),
            (["data", "--fall", "moon=0.1"], "no dataset 'moon'; there are data"),
            (["data", "there/data"], "two datasets are called data"),
        ]:
            done = self.run_script(*arguments)
            self.assertEqual(done.returncode, 2, arguments)
            self.assertIn(message, done.stderr)


if __name__ == "__main__":
    unittest.main()
