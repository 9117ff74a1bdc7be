#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""fransac track on a rendered walk and on streams: track_test.py FRANSAC."""
import json
import pathlib
import resource
import signal
import struct
import subprocess
import sys
import tempfile
import unittest

import inputs

FRANSAC = ""
FRAMES = 6
HEADER = "fransac-depth 1 64 48 uint16 0.001 60 60 31.5 23.5\n"


def frame_bytes(time, depth=None, kind="H"):
    depth = inputs.scene()[0] if depth is None else depth
    return struct.pack(f"<d{len(depth)}{kind}", time, *depth)


def track(*arguments, stdin=b""):
    return subprocess.run([FRANSAC, "track", *map(str, arguments)], input=stdin, capture_output=True, timeout=100, check=False)


def documents(output):
    """Each line is one; the last one ends."""
    assert not output or output.endswith(b"\n"), "half a line"
    return [json.loads(line) for line in output.splitlines()]


def without_times(lines):
    return [{key: value for key, value in line.items() if key != "timing_ms"} for line in lines]


class Walk(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.folder = pathlib.Path(cls.temporary.name, "walk")
        subprocess.run([FRANSAC, "synth", cls.folder, "--scene", "empty_room", "--motion", "walk", "--frames", str(FRAMES), "--width",
                        "320", "--height", "240"], check=True)
        cls.done = track(cls.folder, "--threads", "1")

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()

    def test_one_line_a_frame_and_constant_ids(self):
        self.assertEqual(self.done.returncode, 0, self.done.stderr)
        lines = documents(self.done.stdout)
        self.assertEqual([line["frame"] for line in lines], list(range(FRAMES)))
        for line in lines:
            self.assertAlmostEqual(line["timestamp_s"], line["frame"] / 30, places=5)
        # The largest plane of the first frame is still it, and as old as the walk.
        first = max(lines[0]["planes"], key=lambda plane: plane["area_m2"])
        for line in lines:
            plane = next(plane for plane in line["planes"] if plane["id"] == first["id"])
            self.assertEqual(plane["age"], line["frame"] + 1)
        ids = [plane["id"] for line in lines for plane in line["planes"]]
        self.assertLessEqual(len(set(ids)), max(len(line["planes"]) for line in lines) + 1)

    def test_threads_change_nothing_but_time(self):
        other = track(self.folder, "--threads", "2")
        self.assertEqual(other.returncode, 0, other.stderr)
        self.assertEqual(without_times(documents(other.stdout)), without_times(documents(self.done.stdout)))

    def test_given_poses_are_those_of_the_lines(self):
        done = track(self.folder, "--poses", self.folder / "groundtruth.txt")
        self.assertEqual(done.returncode, 0, done.stderr)
        text = (self.folder / "groundtruth.txt").read_text(encoding="utf-8").splitlines()
        truth = [list(map(float, line.split())) for line in text if not line.startswith("#")]
        for line, pose in zip(documents(done.stdout), truth):
            self.assertEqual(line["pose"]["source"], "given")
            for found, wanted in zip(line["pose"]["translation"], pose[1:4]):
                self.assertAlmostEqual(found, wanted, places=6)


class Stream(unittest.TestCase):
    def fails(self, stdin, message, lines=0):
        for threads in (1, 2):
            done = track("-", "--threads", threads, stdin=stdin)
            self.assertEqual(done.returncode, 1)
            self.assertIn(message, done.stderr.decode())
            self.assertEqual(len(documents(done.stdout)), lines)

    def test_frames_of_both_kinds_give_the_same(self):
        metres = [value / 1000 for value in inputs.scene()[0]]
        units = track("-", stdin=HEADER.encode() + b"".join(frame_bytes(0.5 * i) for i in range(4)))
        header = HEADER.replace("uint16 0.001", "float32 1").encode()
        floats = track("-", stdin=header + b"".join(frame_bytes(0.5 * i, metres, "f") for i in range(4)))
        for done in (units, floats):
            self.assertEqual(done.returncode, 0, done.stderr)
            lines = documents(done.stdout)
            self.assertEqual([line["timestamp_s"] for line in lines], [0.0, 0.5, 1.0, 1.5])
            self.assertTrue(all(line["planes"][0]["id"] == 1 for line in lines))
            self.assertAlmostEqual(lines[0]["planes"][0]["d"], 2.0, places=3)

    def test_a_truncated_stream_fails_after_its_whole_frames(self):
        whole = HEADER.encode() + frame_bytes(0.0) + frame_bytes(0.1)
        self.fails(whole + frame_bytes(0.2)[:1000], "standard input: ends within frame 2", 2)
        self.fails(whole + b"abc", "standard input: ends within frame 2", 2)
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder, "lines.jsonl")
            self.assertEqual(track("-", "--json", file, stdin=whole + b"abc").returncode, 1)
            self.assertEqual(list(pathlib.Path(folder).iterdir()), [])

    def test_wrong_headers(self):
        form = 'the first line is not "fransac-depth 1 WIDTH'
        for header, message in (
                ("", form), ("\n", form), ("x" * 100000, form), ("\0\n", form),
                (HEADER.replace("fransac-depth", "depth"), form), (HEADER.replace(" 1 ", " 2 "), form),
                (HEADER.replace("\n", " 7\n"), form), (HEADER.replace(" 23.5", ""), form), (HEADER.replace("64", "x"), form),
                (HEADER.replace("64", "99999999999"), form), (HEADER.replace("uint16", "int8"), "'int8' is neither uint16 nor float32"),
                (HEADER.replace("0.001", "0"), "METRES_PER_UNIT"), (HEADER.replace("0.001", "-1"), "METRES_PER_UNIT"),
                (HEADER.replace("uint16", "float32"), "METRES_PER_UNIT"), (HEADER.replace("64", "0"), "width"),
                (HEADER.replace("64", "40000"), "width"), (HEADER.replace("60 60", "-60 60"), "fx")):
            with self.subTest(header=header[:80]):
                self.fails(header.encode(), message)

    def test_a_size_that_the_stream_does_not_fill_takes_no_memory_for_it(self):
        header = HEADER.replace("64 48 uint16 0.001", "32768 32768 float32 1")
        self.fails(header.encode() + bytes(100), "32768x32768 pixels: more than the limit of 33554432 (--max-size)")
        done = track("-", "--threads", "1", "--max-size", 2**31 - 1, stdin=header.encode() + bytes(100))
        self.assertEqual(done.returncode, 1)
        self.assertIn("ends within frame 0", done.stderr.decode())
        # The most that any process of these tests took, in kB (the frame would take 4 GiB).
        self.assertLess(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss, 1_500_000)

    def test_lines_into_a_link_go_where_it_leads(self):
        with tempfile.TemporaryDirectory() as folder:
            target, link = (pathlib.Path(folder, name) for name in ("lines.jsonl", "link"))
            target.write_text("old", encoding="utf-8")
            link.symlink_to(target)
            self.assertEqual(track("-", "--json", link, stdin=HEADER.encode() + frame_bytes(0.0)).returncode, 0)
            self.assertTrue(link.is_symlink())
            self.assertEqual(len(documents(target.read_bytes())), 1)
            self.assertEqual(sorted(path.name for path in pathlib.Path(folder).iterdir()), ["lines.jsonl", "link"])

    def test_devices_are_written_in_place(self):
        done = track("-", "--json", "/dev/stdout", stdin=HEADER.encode() + frame_bytes(0.0))  # a pipe
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(len(documents(done.stdout)), 1)
        self.assertTrue(pathlib.Path("/dev/stdout").is_symlink())

    def test_a_header_without_frames(self):
        self.fails(HEADER.encode(), "no frame could be used")

    def test_an_interrupt_leaves_whole_lines(self):
        with subprocess.Popen([FRANSAC, "track", "-", "--threads", "1"], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                              stderr=subprocess.PIPE) as process:
            process.stdin.write(HEADER.encode() + frame_bytes(0.0) + frame_bytes(0.1))
            process.stdin.flush()
            lines = process.stdout.readline() + process.stdout.readline()
            process.send_signal(signal.SIGINT)
            rest, errors = process.communicate(frame_bytes(0.2)[:500], timeout=100)
            self.assertEqual(process.returncode, 1, errors)
            self.assertIn("interrupted after 2 frames", errors.decode())
            self.assertEqual(len(documents(lines + rest)), 2)


FRANSAC = sys.argv.pop(1)
unittest.main()
