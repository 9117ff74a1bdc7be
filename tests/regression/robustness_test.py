# SPDX-License-Identifier: Apache-2.0
"""scripts/robustness against a stand-in for the program that measures."""

import os
import pathlib
import stat
import subprocess
import sys
import tempfile
import unittest

SCRIPT = pathlib.Path(__file__).resolve().parents[2] / "scripts/robustness"
HEADER = "kind group frame bar bar_of_mean f1_before f1_after f1_same wiou_before wiou_after wiou_same"


def stand_in(folder, rows, code=0):
    """A program that prints these rows and notes how it was called."""
    program = pathlib.Path(folder) / "measure"
    lines = "\n".join("\t".join(map(str, row)) for row in [HEADER.split(), *rows])
    program.write_text(
        f"#!{sys.executable}\nimport sys\nopen({str(pathlib.Path(folder) / 'call')!r}, 'w').write(' '.join(sys.argv[1:]))\nprint({lines!r})\nsys.exit({code})\n",
        encoding="utf-8",
    )
    program.chmod(program.stat().st_mode | stat.S_IXUSR)
    return program


class Robustness(unittest.TestCase):
    def run_script(self, rows, *arguments, code=0):
        with tempfile.TemporaryDirectory() as folder:
            program = stand_in(folder, rows, code)
            command = [sys.executable, "-B", str(SCRIPT), "--program", str(program), *arguments]
            done = subprocess.run(command, capture_output=True, text=True, check=False, env=os.environ)
            call = pathlib.Path(folder) / "call"
            self.call = call.read_text(encoding="utf-8") if call.exists() else None
            return done

    def test_shares_are_of_sums_over_frames(self):
        rows = [
            ("holes", "tum", "a", 0.9, 0.97, 0.8, 0.8, 0.8, 1.0, 1.0, 1.0),
            ("holes", "tum", "b", 0.9, 0.97, 0.2, 0.1, 0.2, 1.0, 0.9, 0.5),
        ]
        done = self.run_script(rows, "tum", "--check")
        self.assertIn("| holes | 2 | 0.90 | 0.95 | 1.00 | 0.75 |", done.stdout)
        self.assertIn("| mean over kinds | | 0.90* | 0.95* | | |", done.stdout)
        self.assertEqual(done.returncode, 1)

    def test_each_kind_has_its_own_bar(self):
        rows = [
            ("every 8th pixel", "tum", "a", 0.75, 0.5, 1, 0.8, 1, 1, 0.7, 1),
            ("mirrored", "tum", "a", 0.9, 0.5, 1, 0.8, 1, 1, 1, 1),
        ]
        done = self.run_script(rows, "tum")
        self.assertIn("| every 8th pixel | 1 | 0.80 | 0.70* |", done.stdout)
        self.assertIn("| mirrored | 1 | 0.80* | 1.00 |", done.stdout)
        self.assertEqual(done.returncode, 0)  # nobody asked for a check

    def test_check_passes_where_all_bars_are_reached(self):
        rows = [("mirrored", "tum", "a", 0.9, 0.97, 1, 1, 1, 1, 0.97, 1)]
        self.assertEqual(self.run_script(rows, "tum", "--check").returncode, 0)

    def test_options_reach_the_program(self):
        rows = [("mirrored", "tum", "a", 0.9, 0.97, 1, 1, 1, 1, 1, 1)]
        done = self.run_script(rows, "folder", "--rendered", "--sensor", "tof", "--only", "mirr", "--frames", "--by-group")
        self.assertEqual(self.call, "--only mirr folder --sensor tof --rendered")
        self.assertIn("| tum | a | mirrored | 1.000 |", done.stdout)
        self.assertEqual(done.stdout.count("| mean over kinds |"), 2)

    def test_failures_are_told(self):
        self.assertEqual(self.run_script([], "tum", code=1).returncode, 2)
        done = self.run_script([], "tum", "--only", "nonsense")
        self.assertEqual(done.returncode, 2)
        self.assertIn("nonsense", done.stderr)


if __name__ == "__main__":
    unittest.main()
