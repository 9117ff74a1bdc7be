#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Chromium opens the pages from disk and draws every picture and plot, in the light and the dark scheme, wide and narrow.

With an argument, a folder: the screenshots stay there. Environment: CHROMIUM, the browser, if it is not on the path."""

import collections
import html
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

import pages

CHROMIUM = os.environ.get("CHROMIUM") or shutil.which("chromium") or shutil.which("chromium-browser")
KEEP = sys.argv.pop() if len(sys.argv) > 1 else None

# Added to a copy of the page; says what a reader would see.
CHECK = """<pre id="check"></pre><script>
addEventListener('load', () => {
  document.querySelectorAll('details').forEach(d => { d.open = true; });
  const box = e => { const b = e.getBBox(); return [b.width, b.height]; };
  const seen = {
    images: [...document.images].map(i => [i.alt, i.complete, i.naturalWidth, i.naturalHeight, i.getBoundingClientRect().width]),
    plots: [...document.querySelectorAll('.plots svg')].map(s => [s.getAttribute('aria-label'), ...box(s),
      [...s.querySelectorAll('text')].filter(t => { const [w, h] = box(t), b = t.getBoundingClientRect(),
        f = s.getBoundingClientRect(); return !w || !h || b.left < f.left - 1 || b.right > f.right + 1 || b.top < f.top - 1 ||
        b.bottom > f.bottom + 1; }).map(t => t.textContent)]),
    bars: [...document.querySelectorAll('.timeline svg')].map(s => [s.getBoundingClientRect(), s.querySelector('path')
      .getBoundingClientRect()]).map(([s, p]) => [s.width, p.width, p.height]),
    overflow: document.documentElement.scrollWidth - document.documentElement.clientWidth,
  };
  document.getElementById('check').textContent = JSON.stringify(seen);
});
</script></body>"""


def chromium(profile, *arguments):
    command = [CHROMIUM, "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--hide-scrollbars",
               "--disable-background-networking", "--disable-component-update", "--disable-sync", "--disable-dev-shm-usage",
               f"--user-data-dir={profile}", *arguments]
    return subprocess.run(command, check=True, capture_output=True, text=True, timeout=120).stdout


@unittest.skipUnless(CHROMIUM, "no chromium: apt-get install chromium")
class Chromium(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.mkdtemp(prefix="fransac_chromium_")
        cls.addClassCleanup(shutil.rmtree, cls.folder, ignore_errors=True)
        pages.synth(cls.folder, frames=2)
        cls.page = pages.report(cls.folder, "scenes", "--planes", "all", "--pictures", "1")
        pages.walk(cls.folder, "a_walk_with_a_name_of_many_letters_and_of_nothing_else_but_letters", "desk", frames=6)
        index = pages.report(cls.folder, "a_walk_with_a_name_of_many_letters_and_of_nothing_else_but_letters", "--method", "cells",
                             "--obstacles", out="sequence")
        cls.sequence = next(path for path in index.parent.iterdir() if path != index)

    def test_every_picture_and_plot_is_drawn(self):
        self.assert_drawn(self.page, 4)

    def test_the_page_of_a_sequence_is_drawn(self):
        self.assert_drawn(self.sequence, 2)

    def assert_drawn(self, page, plots):
        source = page.read_text(encoding="utf-8")
        copy = page.with_name("check.html")
        copy.write_text(source.replace("</body>", CHECK), encoding="utf-8")
        for width in (1280, 480):
            with self.subTest(width=width):
                dom = chromium(f"{self.folder}/profile", f"--window-size={width},900", "--dump-dom", copy.as_uri())
                seen = json.loads(html.unescape(re.search(r'<pre id="check">(.*?)</pre>', dom, re.S).group(1)))
                self.assertEqual(len(seen["images"]), source.count("<img "))
                for alt, complete, natural_width, natural_height, shown in seen["images"]:
                    self.assertTrue(complete and natural_width > 0 and natural_height > 0 and shown > 50, alt)
                self.assertEqual(len(seen["plots"]), plots)
                for title, plot_width, plot_height, misplaced in seen["plots"]:
                    self.assertGreater(plot_width, 400, title)
                    self.assertGreater(plot_height, 150, title)
                    self.assertEqual(misplaced, [], title)
                self.assertEqual(len(seen["bars"]), source.count("<td class=\"time\">"))
                for place, bar_width, bar_height in seen["bars"]:
                    self.assertTrue(place > 100 and bar_width > 1 and bar_height > 5)
                self.assertLessEqual(seen["overflow"], 0, "the page scrolls sideways")

    def test_screenshots_show_something(self):
        for name, scheme, width, page in (("light", 1, 1280, self.page), ("dark", 0, 1280, self.page), ("narrow", 1, 480, self.page),
                                          ("sequence", 1, 1280, self.sequence)):
            with self.subTest(name):
                file = pathlib.Path(KEEP or self.folder, f"{name}.png")
                chromium(f"{self.folder}/profile", f"--window-size={width},2400", f"--screenshot={file}",
                         f"--force-device-scale-factor={1 if KEEP else 0.4}",  # pixels are decoded in Python
                         f"--blink-settings=preferredColorScheme={scheme}", page.as_uri())
                rows = pages.pixels(file.read_bytes(), 2)
                flat = [colour for row in rows for colour in row]
                paper = collections.Counter(flat).most_common(1)[0][0]
                self.assertEqual(sum(paper) > 600, name != "dark", f"paper is {paper}")
                self.assertGreater(len(set(flat)), 200, "hardly any colours")
                self.assertGreater(sum(colour != paper for colour in flat), len(flat) / 10, "almost blank")


if __name__ == "__main__":
    unittest.main()
