#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What commands leave on the disk when they are killed, interrupted, run twice at once or cannot say a word: files_test.py FRANSAC."""
import fcntl
import json
import os
import pathlib
import random
import resource
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import termios
import time
import unittest

import inputs

FRANSAC = ""
HEADER = b"fransac-depth 1 64 48 uint16 0.001 60 60 31.5 23.5\n"


def frame_bytes(i):
    return struct.pack(f"<d{inputs.WIDTH * inputs.HEIGHT}H", 0.1 * i, *inputs.scene()[0])


def run(*arguments, folder, **options):
    return subprocess.run([FRANSAC, *map(str, arguments)], cwd=folder, capture_output=True, timeout=100, check=False, **options)


def start(*arguments, folder):
    return subprocess.Popen([FRANSAC, *map(str, arguments)], cwd=folder, stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                            stderr=subprocess.PIPE)


def content(folder):
    """Every file of a folder and what is in it; folders end in '/'."""
    return {str(path.relative_to(folder)) + ("/" if path.is_dir() else ""): None if path.is_dir() else path.read_bytes()
            for path in pathlib.Path(folder).rglob("*")}


class InFolder(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory(prefix="fransac_files_")
        self.addCleanup(temporary.cleanup)
        self.folder = pathlib.Path(temporary.name)

    def wait_for(self, condition):
        for _ in range(2000):
            if condition():
                return
            time.sleep(0.005)
        self.fail("nothing happened")

    def temporaries(self):
        return [path for path in self.folder.rglob(".fransac-*")]


class Stderr(InFolder):
    """Messages that nobody can read neither end a run nor change its results."""

    def setUp(self):
        super().setUp()
        inputs.noise_frame(self.folder, "noise")  # has no plane, which is said

    def results(self, redirection):
        command = f'"$0" segment noise --method ransac --min-support 0.2 --labels l.png --json - {redirection}'
        done = subprocess.run(["bash", "-o", "pipefail", "-c", command, FRANSAC], cwd=self.folder, stdout=subprocess.PIPE, timeout=100,
                              check=False)
        self.assertEqual(json.loads(done.stdout)["planes"], [])
        self.assertEqual(next(inputs.png_chunks((self.folder / "l.png").read_bytes()))[0], b"IHDR")
        return done.returncode

    def test_full(self):
        self.assertEqual(self.results("2>/dev/full"), 0)

    def test_closed(self):
        self.assertEqual(self.results("2>&-"), 0)

    def test_a_reader_that_is_gone(self):
        self.assertEqual(self.results("2> >(true)"), 0)

    def test_a_failure_is_still_a_failure(self):
        for redirection in ("2>/dev/full", "2>&-"):
            done = subprocess.run(["bash", "-c", f'"$0" segment nowhere {redirection}', FRANSAC], cwd=self.folder, timeout=100,
                                  check=False)
            self.assertEqual(done.returncode, 1)

    def test_a_closed_stderr_is_no_output_file(self):
        """The first file that is opened must not get the number of stderr, or messages would go into it."""
        inputs.dataset_with_broken_frame(self.folder, "data")
        subprocess.run(["bash", "-c", '"$0" segment data --labels out 2>&- >/dev/null', FRANSAC], cwd=self.folder, timeout=100, check=False)
        for name in ("frame0.png", "frame2.png"):
            self.assertTrue((self.folder / "out" / name).read_bytes().startswith(inputs.PNG_SIGNATURE))


class ClosedStdout(InFolder):
    def setUp(self):
        super().setUp()
        inputs.frame(self.folder, "frame")

    def test_results_that_go_nowhere_are_a_failure(self):
        for command in ("segment frame", "segment frame --json -", "--version", "man"):
            done = subprocess.run(["bash", "-c", f'"$0" {command} >&-', FRANSAC], cwd=self.folder, stderr=subprocess.PIPE, timeout=100,
                                  check=False)
            self.assertEqual((done.returncode, done.stderr), (1, b"fransac: standard output: Bad file descriptor\n"), command)

    def test_its_names_stay_what_they_are(self):
        """By a link of our own to /dev/stdout: should it be replaced, then this one."""
        link = self.folder / "stdout"
        link.symlink_to("/proc/self/fd/1")
        stream = HEADER + frame_bytes(0)
        for command in ("segment frame --json stdout", "track - --json stdout"):
            done = subprocess.run(["bash", "-c", f'"$0" {command} >&-', FRANSAC], cwd=self.folder, input=stream, stderr=subprocess.PIPE,
                                  timeout=100, check=False)
            self.assertEqual((done.returncode, done.stderr), (1, b"fransac: stdout: Bad file descriptor\n"), command)
            self.assertEqual(os.readlink(link), "/proc/self/fd/1")


class Inputs(InFolder):
    """No output may be a file of the input, whatever its name."""

    def refused(self, *arguments, option):
        before = content(self.folder)
        done = run(*arguments, folder=self.folder)
        self.assertEqual(done.returncode, 2, done.stderr)
        self.assertIn(f"fransac: {option}: ", done.stderr.decode())
        self.assertIn("is part of the input", done.stderr.decode())
        self.assertEqual(content(self.folder), before)

    def test_of_a_frame(self):
        inputs.frame_with_regions(self.folder, "f")
        shutil.copy(self.folder / "f" / "labels.png", self.folder / "f" / "objects.png")
        for name in ("depth.png", "labels.png", "objects.png", "gt_seg.png"):
            self.refused("segment", "f", "--obstacles", "--obstacle-labels", f"f/{name}", option="--obstacle-labels")
        for name in ("camera.json", "objects.png", "dataset.json"):
            self.refused("segment", "f", "--json", f"f/{name}", option="--json")
            self.refused("evaluate", "f", "--json", f"f/{name}", option="--json")
            self.refused("evaluate", "f", "--csv", f"f/../f/{name}", option="--csv")
            self.refused("bench", "f", "--json", f"f/{name}", option="--json")
            self.refused("calibrate", "f", "--out", f"f/{name}", option="--out")
        (self.folder / "link").symlink_to("f/depth.png")
        os.link(self.folder / "f" / "depth.png", self.folder / "same")
        for name in ("link", "same"):
            self.refused("segment", "f", "--json", name, option="--json")

    def test_of_a_sequence(self):
        inputs.sequence(self.folder, "seq")
        inputs.text(self.folder, "seq/groundtruth.txt", "100.0 0 0 0 0 0 0 1\n")
        shutil.copy(self.folder / "seq" / "groundtruth.txt", self.folder / "poses.txt")
        for name in ("seq/depth.txt", "seq/groundtruth.txt", "seq/depth/1.png", "seq/camera.json", "poses.txt"):
            self.refused("track", "seq", "--poses", "poses.txt", "--json", name, option="--json")

    def test_of_options(self):
        inputs.frame(self.folder, "f")
        shutil.copy(self.folder / "f" / "camera.json", self.folder / "g.yaml")
        inputs.sensor(self.folder, "sensor.json", "{}")
        self.refused("segment", "f", "--camera", "g.yaml", "--obstacles", "--grid", "0.1", "--grid-out", "g", option="--grid-out")
        self.refused("segment", "f", "--camera", "g.yaml", "--json", "f/camera.json", option="--json")
        self.refused("segment", "f", "--sensor", "sensor.json", "--json", "sensor.json", option="--json")

    def test_of_other_frames(self):
        inputs.dataset(self.folder, "data")
        for frame in (0, 1):  # frame 0's result would be frame 1's depth
            (self.folder / "out").mkdir()
            (self.folder / "out" / f"frame{frame}.png").symlink_to(f"../data/frame{1 - frame}/depth.png")
            self.refused("segment", "data", "--labels", "out", option="--labels")
            shutil.rmtree(self.folder / "out")

    def test_outputs_of_one_run_are_different_files(self):
        inputs.dataset(self.folder, "data")
        done = run("segment", "data", "--labels", "out", "--overlay", "./out", folder=self.folder)
        self.assertEqual(done.returncode, 2)
        self.assertIn("--overlay: './out/frame0.png' would be written twice", done.stderr.decode())


class Track(InFolder):
    """--json FILE appears when the last line is written."""

    def follow(self, *arguments):
        begun = self.begun()
        process = start("track", "-", "--threads", "1", "--json", "lines", *arguments, folder=self.folder)
        process.stdin.write(HEADER + frame_bytes(0) + frame_bytes(1))
        process.stdin.flush()
        self.wait_for(lambda: self.begun() > begun)
        return process

    def begun(self):
        return sum(path.stat().st_size > 0 for path in self.temporaries())

    def finish(self, process, frames=0):
        return process.communicate(b"".join(frame_bytes(2 + i) for i in range(frames)), timeout=100)

    def test_two_at_once_give_one_whole_file(self):
        first, second = self.follow(), self.follow()
        self.assertEqual(len(self.temporaries()), 2)
        self.finish(first, 40)
        self.finish(second, 20)
        self.assertEqual((first.returncode, second.returncode), (0, 0))
        self.assertEqual([json.loads(line)["frame"] for line in (self.folder / "lines").read_text().splitlines()], list(range(22)))
        self.assertEqual(list(content(self.folder)), ["lines"])

    def test_signals_keep_the_old_file(self):
        (self.folder / "lines").write_text("old")
        (self.folder / "lines.part").write_text("mine")
        before = content(self.folder)
        for number in (signal.SIGTERM, signal.SIGHUP, signal.SIGINT):
            process = self.follow()
            process.send_signal(number)
            if number == signal.SIGINT:  # ends the reading, and says so
                _, errors = self.finish(process, 1)
                self.assertEqual(process.returncode, 1)
                self.assertIn(b"so --json is not written", errors)
            else:
                self.assertEqual(process.wait(timeout=100), -number)
                self.finish(process)
            self.assertEqual(content(self.folder), before)

    def test_a_second_interrupt_ends_it_at_once(self):
        process = self.follow()
        self.wait_for(lambda: self.temporaries()[0].read_bytes().count(b"\n") == 2)
        process.stdin.write(frame_bytes(2)[:1000])  # once this is read, the reader waits for the rest
        process.stdin.flush()
        self.wait_for(lambda: struct.unpack("i", fcntl.ioctl(process.stdin, termios.FIONREAD, bytes(4))) == (0,))
        process.send_signal(signal.SIGINT)
        status = pathlib.Path(f"/proc/{process.pid}/status")
        self.wait_for(lambda: "ShdPnd:\t0000000000000000" in status.read_text())  # two at once would be one
        process.send_signal(signal.SIGINT)
        self.assertEqual(process.wait(timeout=100), -signal.SIGINT)
        self.finish(process)
        self.assertEqual(content(self.folder), {})

    def test_ignored_signals_stay_ignored(self):
        command = 'trap "" HUP; exec "$0" track - --threads 1 --json lines'
        process = subprocess.Popen(["bash", "-c", command, FRANSAC], cwd=self.folder, stdin=subprocess.PIPE, stderr=subprocess.PIPE)
        process.stdin.write(HEADER + frame_bytes(0))
        process.stdin.flush()
        self.wait_for(self.temporaries)
        process.send_signal(signal.SIGHUP)
        self.finish(process, 1)
        self.assertEqual(process.returncode, 0)

    def test_what_a_killed_run_leaves_the_next_one_removes(self):
        process = self.follow()
        process.kill()
        self.finish(process)
        self.assertEqual(len(self.temporaries()), 1)
        done = run("track", "-", "--json", "lines", folder=self.folder, input=HEADER + frame_bytes(0))
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(list(content(self.folder)), ["lines"])

    def test_a_running_one_is_left_alone(self):
        process = self.follow()
        done = run("track", "-", "--json", "lines", folder=self.folder, input=HEADER + frame_bytes(0))
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(len(self.temporaries()), 1)
        self.finish(process)
        self.assertEqual(process.returncode, 0)
        self.assertEqual(len((self.folder / "lines").read_text().splitlines()), 2)

    def test_a_file_that_grows_too_large(self):
        (self.folder / "lines").write_text("old")
        limit = lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096))
        stream = HEADER + b"".join(frame_bytes(i) for i in range(20))
        done = run("track", "-", "--json", "lines", folder=self.folder, input=stream, preexec_fn=limit)
        self.assertEqual((done.returncode, done.stderr), (1, b"fransac: lines: File too large\n"))
        self.assertEqual(content(self.folder), {"lines": b"old"})

    def test_permissions_of_the_old_file_stay(self):
        (self.folder / "lines").write_text("old")
        (self.folder / "lines").chmod(0o640)
        self.assertEqual(run("track", "-", "--json", "lines", folder=self.folder, input=HEADER + frame_bytes(0)).returncode, 0)
        self.assertEqual((self.folder / "lines").stat().st_mode & 0o777, 0o640)


class Killed(InFolder):
    """Twelve kills of each command at random times: every file is the old one or a whole one, and a rerun leaves nothing else."""

    KILLS = 12

    def setUp(self):
        super().setUp()
        self.random = random.Random(self.id())
        self.assertEqual(run("synth", "in", "--scene", "desk", "--motion", "walk", "--frames", "6", "--width", "160", "--height", "120",
                             folder=self.folder).returncode, 0)
        (self.folder / "out").mkdir()

    def check(self, *arguments, is_whole, output="out"):
        begin = time.monotonic()
        self.assertEqual(run(*arguments, folder=self.folder).returncode, 0)
        duration = time.monotonic() - begin
        names = {name for name in content(self.folder / "out")}
        killed = 0
        for number in range(self.KILLS):
            shutil.rmtree(self.folder / "out")
            (self.folder / "out").mkdir()
            old = number % 2 == 0 and output == "out"  # else there is no old file, or there may be none
            if old:
                for name in names:
                    (self.folder / "out" / name).write_bytes(b"old")
            process = start(*arguments, folder=self.folder)
            time.sleep(self.random.uniform(0, duration))
            process.send_signal(self.random.choice((signal.SIGKILL, signal.SIGTERM)))
            process.communicate(timeout=100)
            killed += process.returncode < 0
            for name, data in content(self.folder / "out").items():
                if pathlib.PurePath(name).name.startswith(".fransac-") or "/.fransac-" in f"/{name}":
                    continue
                self.assertTrue(data is None or (old and data == b"old") or is_whole(name, data), (number, name))
            if old:
                self.assertLessEqual(names, set(content(self.folder / "out")), "an old file is lost")
            if output != "out" and (self.folder / output).exists():  # it was done before
                continue
            self.assertEqual(run(*arguments, folder=self.folder).returncode, 0)
            self.assertEqual(set(content(self.folder / "out")), names)
            self.assertEqual(self.temporaries(), [])
        self.assertGreater(killed, 0)

    @staticmethod
    def whole_png(data):
        return data.startswith(inputs.PNG_SIGNATURE) and data.endswith(inputs.chunk(b"IEND", b""))

    def test_segment(self):
        def is_whole(name, data):
            return self.whole_png(data) if name.endswith(".png") else bool(json.loads(data))
        self.check("segment", "in", "--labels", "out", "--json", "out", is_whole=is_whole)

    def test_track(self):
        self.check("track", "in", "--json", "out/lines", is_whole=lambda name, data: len([json.loads(x) for x in data.splitlines()]) == 6)

    def test_report(self):
        self.check("report", "in", "--out", "out", "--repeat", "1", "--method", "cells",
                   is_whole=lambda name, data: data.rstrip().endswith(b"</html>"))

    def test_synth(self):
        def is_whole(name, data):
            return self.whole_png(data) if name.endswith(".png") else len(data) > 0
        self.check("synth", "out/new", "--scene", "desk", "--frames", "5", "--width", "160", "--height", "120", is_whole=is_whole,
                   output="out/new")


FRANSAC = sys.argv.pop(1)
unittest.main()
