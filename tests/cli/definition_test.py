#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The manual page and the completions that the program writes: definition_test.py FRANSAC. Needs nothing but bash; what mandoc, groff,
zsh and fish would say is skipped where they are missing.
"""
import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

FRANSAC = os.path.abspath(sys.argv.pop(1))
COMMANDS = ("segment", "track", "evaluate", "report", "bench", "synth", "calibrate")


def run(*words, **more):
    return subprocess.run(words, capture_output=True, text=True, check=False, **more)


def fransac(*words):
    done = run(FRANSAC, *words)
    assert done.returncode == 0, done.stderr
    return done.stdout


def options_of_help(command):
    """Every name of an option in `fransac COMMAND --help`."""
    lines = re.findall(r"^  (-\S+)", fransac(*command, "--help"), re.M)
    return [name for line in lines for name in line.split(",")]


def shown_options(command):
    """Name and example of every option in `fransac COMMAND -h`."""
    return re.findall(r"^  (-\S+).*\n +e\.g\. (.*)", fransac(command, "-h"), re.M)


def needs(tool):
    return unittest.skipUnless(shutil.which(tool), f"{tool} is not installed")


class Files(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def written(self, name, text):
        path = os.path.join(self.folder.name, name)
        with open(path, "w", encoding="utf-8") as file:
            file.write(text)
        return path


class Manual(Files):
    def sections(self):
        """The page's plain text by section title."""
        parts = re.split(r'^\.SH "?([^"\n]+)"?\n', fransac("man"), flags=re.M)
        return {title: text.replace("\\-", "-").replace("\\:", "") for title, text in zip(parts[1::2], parts[2::2])}

    def test_every_option_of_help_is_there(self):
        sections = self.sections()
        for command in COMMANDS:
            headings = re.findall(r"^\.TP\n(.*)", sections[f"COMMAND {command}"], re.M)
            names = {name for heading in headings for name in re.findall(r"\\fB(-[^\\]+)\\fR", heading)}
            with self.subTest(command):
                self.assertGreater(len(names), 5)
                self.assertEqual(names, set(options_of_help([command])))
        self.assertIn("--version", sections["OPTIONS"])

    def test_groups_defaults_and_exit_codes(self):
        sections = self.sections()
        segment = sections["COMMAND segment"]
        self.assertLess(segment.index("\nParameters of the methods:"), segment.index("--threshold"))
        self.assertLess(segment.index("\nObstacles:"), segment.index("--least-height"))
        self.assertRegex(segment, r"--leaf-size.*\n.*default: 0\.02\]")
        self.assertIn("(needs --grid-out)", segment)
        self.assertIn("2 wrong usage", sections["EXIT STATUS"])
        self.assertNotIn("completion", fransac("--help"))

    @needs("groff")
    def test_groff_has_no_complaint(self):
        done = run("groff", "-man", "-ww", "-Tutf8", "-z", self.written("fransac.1", fransac("man")))
        self.assertEqual(done.stderr, "")

    @needs("mandoc")
    def test_mandoc_has_no_complaint(self):
        done = run("mandoc", "-Tlint", "-Wwarning", self.written("fransac.1", fransac("man")))
        # Without a date the page is the same on every run.
        complaints = [line for line in done.stdout.splitlines() if "missing date" not in line]
        self.assertEqual(complaints, [])


class ShortHelp(Files):
    def test_its_examples_do_what_they_say(self):
        fransac("synth", f"{self.folder.name}/desks")
        fransac("synth", f"{self.folder.name}/walk", "--motion", "walk", "--frames", "3", "--width", "160", "--height", "120")
        os.rename(f"{self.folder.name}/desks/desk_0_0", f"{self.folder.name}/desk")
        fransac("segment", f"{self.folder.name}/desk", "--cloud", f"{self.folder.name}/scan.pcd")
        for name in ("depth.png", "camera.json"):
            shutil.copy(f"{self.folder.name}/desk/{name}", self.folder.name)
        os.rename(f"{self.folder.name}/walk", f"{self.folder.name}/frames")
        for link in ("walk", "sequence", "rooms"):
            os.symlink("frames", f"{self.folder.name}/{link}")
        for command in COMMANDS:
            shown = shown_options(command)
            self.assertGreater(len(shown), 1, command)
            for option, example in shown:
                with self.subTest(example):
                    words = example.split()
                    self.assertIn(option, words)
                    done = run(FRANSAC, *words[1:], cwd=self.folder.name)
                    self.assertEqual(done.returncode, 0, done.stderr)


class Completion(Files):
    # What is typed (the last word is completed), and what must be offered.
    CASES = [
        (["se"], ["segment"]),
        (["--v"], ["--version"]),
        (["segment", "--method", "vox"], ["voxel-ransac"]),
        (["segment", "--support", "t"], ["table"]),
        (["bench", "--method", "cells,rr"], ["cells,rransac"]),
        (["synth", "--noise", "k"], ["kinect1"]),
        (["segment", "--no-pass-through-"], ["--no-pass-through-outside"]),
        (["segment", "--labels", "dep"], ["depth.png"]),
        (["segment", "dep"], ["depth.png"]),
        (["segment", "--sensor-param", "disp"], ["disparity-error="]),
    ]

    def setUp(self):
        super().setUp()
        self.written("depth.png", "")

    def script(self, shell):
        return self.written(f"completion.{shell}", fransac("completion", shell))

    def bash(self, *words):
        typed = " ".join(f"'{word}'" for word in (FRANSAC, *words))
        source = f"source {self.script('bash')}; COMP_WORDS=({typed}); COMP_CWORD={len(words)}; _fransac; printf '%s\\n' \"${{COMPREPLY[@]}}\""
        done = run("bash", "-c", source, cwd=self.folder.name)
        self.assertEqual(done.stderr, "")
        return done.stdout.split()

    def test_bash_completes(self):
        self.assertEqual(run("bash", "-n", self.script("bash")).stderr, "")
        for typed, offered in self.CASES:
            with self.subTest(" ".join(typed)):
                self.assertEqual(self.bash(*typed), offered)
        self.assertEqual(self.bash("segment", "--method", "=", "vox"), ["voxel-ransac"])  # bash splits --method=vox so
        self.assertEqual(self.bash("segment", "--threshold", ""), [])
        self.assertEqual(self.bash("report", "--out", "dep"), [])
        self.assertEqual(self.bash(""), [*COMMANDS, "-h", "--help", "--version"])
        self.assertEqual(self.bash("segment", "--method=vox"), ["--method=voxel-ransac"])  # other shells do not

    def test_bash_offers_every_option(self):
        for command in COMMANDS:
            self.assertEqual(sorted(self.bash(command, "-")), sorted(options_of_help([command])))

    @needs("fish")
    def test_fish_completes(self):
        script = self.script("fish")
        self.assertEqual(run("fish", "-n", script).stderr, "")
        for typed, offered in self.CASES:
            with self.subTest(" ".join(typed)):
                done = run("fish", "--no-config", "-c", f"set PATH {os.path.dirname(FRANSAC)} $PATH; source {script}; complete -C '{' '.join(['fransac', *typed])}'", cwd=self.folder.name)
                self.assertEqual([line.split("\t")[0] for line in done.stdout.splitlines()], offered, done.stderr)

    @needs("zsh")
    def test_zsh_reads_it(self):
        script = self.script("zsh")
        self.assertEqual(run("zsh", "-fn", script).stderr, "")
        done = run("zsh", "-fc", f"autoload -Uz compinit && compinit -D -u && source {script} && print $_comps[fransac]")
        self.assertEqual((done.stdout, done.stderr), ("_fransac\n", ""))

    def test_other_shells_are_refused(self):
        done = run(FRANSAC, "completion", "tcsh")
        self.assertEqual((done.returncode, done.stdout), (2, ""))
        self.assertIn("'tcsh'", done.stderr)


unittest.main(verbosity=2)
