#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The tree keeps its rules, and the checks notice when it does not.

Environment: FRANSAC_SOURCE_DIR, the tree; FRANSAC_LIBRARIES, the built libraries separated by ':'; NM, the tool.
"""

import os
import pathlib
import subprocess
import tempfile
import unittest

import rules

ROOT = os.environ.get("FRANSAC_SOURCE_DIR", str(pathlib.Path(__file__).resolve().parents[2]))


class Tree(unittest.TestCase):
    """This tree."""

    def assert_none(self, complaints):
        self.assertFalse(complaints, "\n" + "\n".join(complaints))

    def test_includes_follow_the_arrows(self):
        self.assert_none(rules.check_includes(ROOT))

    def test_every_source_names_its_licence(self):
        self.assert_none(rules.check_spdx(ROOT))

    def test_the_version_stands_once(self):
        self.assert_none(rules.check_version(ROOT))

    def test_the_citation_is_of_this_version(self):
        self.assert_none(rules.check_citation(ROOT))

    def test_links_lead_somewhere(self):
        self.assert_none(rules.check_links(ROOT))

    def test_allocation_failures_are_tested_of_every_fallible_function(self):
        self.assert_none(rules.check_failures_tested(ROOT))

    def test_runs_are_repeatable(self):
        self.assert_none(rules.check_repeatable(ROOT))


@unittest.skipUnless("FRANSAC_LIBRARIES" in os.environ, "no optimised libraries to look into")
class Libraries(unittest.TestCase):
    """The libraries as built."""

    def test_they_never_print_and_never_end_the_program(self):
        for library in os.environ["FRANSAC_LIBRARIES"].split(":"):
            output = subprocess.run(
                [os.environ.get("NM", "nm"), "-C", "--undefined-only", *dynamic(library), library],
                check=True, capture_output=True, text=True,
            ).stdout
            self.assertIn(" U ", output, library)
            complaints = rules.check_symbols(output)
            self.assertFalse(complaints, f"\n{library}\n" + "\n".join(complaints))


def dynamic(library):
    return [] if library.endswith(".a") else ["--dynamic"]


class Checks(unittest.TestCase):
    """The checks themselves, on trees with one fault each."""

    def complaints(self, check, tree):
        with tempfile.TemporaryDirectory() as root:
            for name, text in {"CMakeLists.txt": "project(fransac VERSION 1.2.3)\n", "CMakePresets.json": "{}", **tree}.items():
                path = pathlib.Path(root) / name
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_text(text, encoding="utf-8")
            return check(root)

    def test_includes(self):
        public, private = "include/fransac/planes/p.hpp", "src/planes/p.hpp"
        faults = {
            "an arrow backwards": {"include/fransac/core/c.hpp": '#include "fransac/planes/p.hpp"\n', public: ""},
            "kernels that know core": {"src/kernels/k.h": '#include "fransac/core/c.hpp"\n', "include/fransac/core/c.hpp": ""},
            "kernels that know Eigen": {"src/kernels/k.h": "#include <Eigen/Core>\n"},
            "a public header that includes a private one": {public: '#include "planes/q.hpp"\n', "src/planes/q.hpp": ""},
            "a public header with a third party": {public: "#include <tbb/parallel_for.h>\n"},
            "Highway outside the kernels": {private: "#include <hwy/highway.h>\n"},
            "TBB elsewhere": {"src/core/c.cc": "#include <tbb/parallel_for.h>\n"},
            "threads made elsewhere": {"src/core/c.cc": "#include <thread>\n"},
            "a program that includes a private header": {"apps/fransac/a.cpp": '#include "planes/p.hpp"\n', private: ""},
            "an adapter that includes a private header": {"adapters/pcl/include/fransac/pcl/a.hpp": '#include "planes/p.hpp"\n', private: ""},
            "the library that includes an adapter": {"src/core/c.cc": '#include "fransac/pcl/a.hpp"\n', "adapters/pcl/include/fransac/pcl/a.hpp": ""},
            "a header that is not there": {private: '#include "planes/missing.hpp"\n'},
            "angle brackets": {private: "#include <fransac/core/c.hpp>\n"},
            "a module without arrows": {"src/novelty/n.cc": ""},
        }
        for what, tree in faults.items():
            with self.subTest(what):
                self.assertEqual(len(self.complaints(rules.check_includes, tree)), 1)
        sound = {
            public: '#include <vector>\n#include <Eigen/Core>\n#include "fransac/sac/s.hpp"\n',
            "include/fransac/sac/s.hpp": "",
            private: '#include "kernels/k.h"\n#include "planes/q.hpp"\n',
            "src/planes/q.hpp": "",
            "src/kernels/k.h": "#include <cstdint>\n",
            "src/kernels/k.cc": '#include <hwy/highway.h>\n#include "kernels/k.h"\n',
            "apps/fransac/a.cpp": '#include "a.hpp"\n#include "fransac/planes/p.hpp"\n#include <CLI/CLI.hpp>\n',
            "apps/fransac/a.hpp": "",
            "adapters/pcl/include/fransac/pcl/a.hpp": '#include <pcl/pcl_base.h>\n#include "fransac/pcl/b.hpp"\n#include "fransac/planes/p.hpp"\n',
            "adapters/pcl/include/fransac/pcl/b.hpp": "#include <Eigen/Core>\n",
        }
        self.assertEqual(self.complaints(rules.check_includes, sound), [])

    def test_licence(self):
        self.assertEqual(len(self.complaints(rules.check_spdx, {"src/core/c.cc": "int i;\n"})), 1)
        self.assertEqual(self.complaints(rules.check_spdx, {"scripts/s": f"#!/bin/sh\n# {rules.SPDX}\n"}), [])

    def test_version(self):
        self.assertEqual(len(self.complaints(rules.check_version, {"src/core/c.cc": 'auto v = "1.2.3";\n'})), 1)
        self.assertEqual(self.complaints(rules.check_version, {"src/core/c.cc": "auto v = 11.2; // 1.2.3.4\n"}), [])

    def test_citation(self):
        self.assertEqual(len(self.complaints(rules.check_citation, {"CITATION.cff": "cff-version: 1.2.0\nversion: 1.2.2\n"})), 1)
        self.assertEqual(self.complaints(rules.check_citation, {"CITATION.cff": "cff-version: 1.2.0\nversion: 1.2.3\n"}), [])

    def test_links(self):
        for fault in ("[a](b.md)", "[a](#b)", "![a](docs/b.svg)", "[a](docs/c.md#e)"):
            with self.subTest(fault):
                self.assertEqual(len(self.complaints(rules.check_links, {"README.md": fault, "docs/c.md": "# D\n"})), 1)
        sound = {"README.md": "[a](docs/c.md#two-words-1) [b](https://x.y/z#a) `[c](d)`", "docs/c.md": "## Two `words` (1)\n[up](../README.md)"}
        self.assertEqual(self.complaints(rules.check_links, sound), [])

    def test_repeatable(self):
        for fault in ("std::random_device d;", "srand(1);", "auto seed = time(nullptr);", "std::chrono::system_clock::now();"):
            with self.subTest(fault):
                self.assertEqual(len(self.complaints(rules.check_repeatable, {"src/core/c.cc": fault})), 1)
        sound = "// no random_device\nint operand(); int x = operand(); double run_time(int); double t = run_time(0);"
        self.assertEqual(self.complaints(rules.check_repeatable, {"src/core/c.cc": sound}), [])

    def test_failures(self):
        header = {"include/fransac/core/c.hpp": "Status validate(int i);\n  Result<std::vector<int>> find(int i);\nint other(int i);\n"}
        calls = [{rules.FAILURES_TEST: text} for text in ("", "find(1);", "validate(1); core::find(2);")]
        self.assertEqual([len(self.complaints(rules.check_failures_tested, {**header, **call})) for call in calls], [2, 1, 0])

    def test_symbols(self):
        for fault in ("printf", "puts@GLIBC_2.2.5", "std::cout", "abort", "exit", "__fprintf_chk", "std::terminate()", "stderr"):
            with self.subTest(fault):
                self.assertEqual(len(rules.check_symbols(f"plane.cc.o:\n                 U {fault}\n")), 1)
        for sound in ("snprintf", "fputs_filter", "atexit", "__cxa_atexit", "std::ostream::flush()", "fwrite"):
            with self.subTest(sound):
                self.assertEqual(rules.check_symbols(f"plane.cc.o:\n                 U {sound}\n"), [])


if __name__ == "__main__":
    unittest.main()
