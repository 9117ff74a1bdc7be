# SPDX-License-Identifier: Apache-2.0
"""scripts/mutate: which faults it makes of a line, which lines it leaves alone, and that its list of equivalent mutants is of this tree."""

import importlib.machinery
import importlib.util
import pathlib
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
loader = importlib.machinery.SourceFileLoader("mutate", str(ROOT / "scripts/mutate"))
mutate = importlib.util.module_from_spec(importlib.util.spec_from_loader("mutate", loader))
loader.exec_module(mutate)


def faults(text):
    return [fault for line, code in zip(text.split("\n"), mutate.code_of(text)) for fault in mutate.faults_of(line, code)]


class Faults(unittest.TestCase):
    def test_comparisons_and_conditions(self):
        self.assertEqual(set(faults("if (!a && b < c) {")),
                         {"if (a && b < c) {", "if (!a || b < c) {", "if (!a && b <= c) {", "if (!a && b >= c) {"})

    def test_arithmetic(self):
        self.assertEqual(set(faults("  return a * b + c;")), {"  return a / b + c;", "  return a * b - c;", "  return {};"})

    def test_constants(self):
        self.assertEqual(set(faults("f(0, 1, 7, 2.5);")),
                         {"f(1, 1, 7, 2.5);", "f(0, 0, 7, 2.5);", "f(0, 2, 7, 2.5);", "f(0, 1, 0, 2.5);", "f(0, 1, 1, 2.5);",
                          "f(0, 1, 7, 0.0);", "f(0, 1, 7, 2.0 * 2.5);", ";"})

    def test_statements(self):
        for statement in ("sum[i] += x;", "region.alive = false;", "++count;", "list.push_back(x);", "if (!x) return;", "if (x) continue;"):
            self.assertIn(";", faults(statement))
        for no_statement in ("double sum = x;", "return;", "b.reserve(n);"):
            self.assertNotIn(";", faults(no_statement))

    def test_minimum_and_maximum(self):
        self.assertIn("x = std::max(a, b);", faults("x = std::min(a, b);"))

    def test_what_is_no_code(self):
        for text in ("// a < b", "/* a < b\n   c < d */", "#define X(a) (a < 1)", "#define X \\\n  a < b", "static_assert(a < b);",
                     "constexpr double kA = 2.0;", "  static constexpr int kB = 2;", 'message = \n    "a < b && c";', "std::vector<int> v;",
                     "void f(T&& x);"):
            self.assertFalse([fault for fault in faults(text) if fault != ";"], text)

    def test_words_keep_their_place(self):
        self.assertEqual(faults('say("1 < 2", a < b, \'<\');  // < 0'),
                         ['say("1 < 2", a <= b, \'<\');  // < 0', 'say("1 < 2", a >= b, \'<\');  // < 0', ";"])


class Draws(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.root = pathlib.Path(self.folder.name)
        (self.root / "a.cc").write_text("\n".join(f"x{i} = y{i} + {i};" for i in range(50)))

    def test_every_line_once_in_an_order_of_the_seed(self):
        one, two = (mutate.draw(self.root, seed, ["a.cc"]) for seed in (1, 2))
        self.assertEqual(sorted(m.line for m in one), list(range(1, 51)))
        self.assertNotEqual([m.line for m in one], [m.line for m in two])
        self.assertEqual(one, mutate.draw(self.root, 1, ["a.cc"]))

    def test_other_lines_do_not_change_a_draw(self):
        before = mutate.draw(self.root, 1, ["a.cc"])
        text = (self.root / "a.cc").read_text()
        (self.root / "a.cc").write_text("z = 1;\n" + text)
        after = [m for m in mutate.draw(self.root, 1, ["a.cc"]) if m.before != "z = 1;"]
        self.assertEqual([m.after for m in before], [m.after for m in after])


class Equivalents(unittest.TestCase):
    def test_the_list_is_of_this_tree(self):
        mutate.equivalents(ROOT)

    def test_an_entry_of_another_line_is_an_error(self):
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            (root / "tests/mutation").mkdir(parents=True)
            (root / "a.cc").write_text("x = y + 1;\n")
            known = root / "tests/mutation/equivalent.txt"
            known.write_text("# all\na.cc ¦ x = y + 1; ¦ x = y - 1; ¦ a reason\n")
            self.assertEqual(mutate.equivalents(root), {("a.cc", "x = y + 1;", "x = y - 1;"): "a reason"})
            for wrong in ("a.cc ¦ x = y + 2; ¦ x = y - 2; ¦ r", "a.cc ¦ x = y + 1; ¦ x = z; ¦ r", "b.cc ¦ x = y + 1; ¦ x = y - 1; ¦ r", "a.cc ¦ x"):
                known.write_text(wrong + "\n")
                with self.assertRaises(mutate.Failure):
                    mutate.equivalents(root)


if __name__ == "__main__":
    unittest.main()
