#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Chromium opens the page from disk and draws every picture and plot, in the light and the dark scheme, wide and narrow.

With an argument, a folder: the screenshots stay there. Environment: CHROMIUM, the browser, if it is not on the path."""

import collections
import html
import json
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
    plots: [...document.querySelectorAll('svg')].map(s => [s.getAttribute('aria-label'), ...box(s),
      [...s.querySelectorAll('text')].filter(t => { const [w, h] = box(t), b = t.getBoundingClientRect(),
        f = s.getBoundingClientRect(); return !w || !h || b.left < f.left - 1 || b.right > f.right + 1 || b.top < f.top - 1 ||
        b.bottom > f.bottom + 1; }).map(t => t.textContent)]),
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


def pixels(path):
    """Rows of (r, g, b) of an 8-bit colour PNG, every second row and column."""
    data = path.read_bytes()
    width, height, bits, kind = struct.unpack(">IIBB", data[16:26])
    assert bits == 8 and kind in (2, 6)
    size = 3 if kind == 2 else 4
    packed = b"".join(data[at + 8:at + 8 + length] for at, length in chunks(data, b"IDAT"))
    raw = zlib.decompress(packed)
    stride = width * size
    before = bytearray(stride)
    rows = []
    for v in range(height):
        row = bytearray(raw[v * (stride + 1) + 1:(v + 1) * (stride + 1)])
        unfilter(raw[v * (stride + 1)], row, before, size)
        before = row
        if v % 2 == 0:
            rows.append([tuple(row[u * size:u * size + 3]) for u in range(0, width, 2)])
    return rows


def chunks(data, kind):
    at = 8
    while at < len(data):
        length = struct.unpack(">I", data[at:at + 4])[0]
        if data[at + 4:at + 8] == kind:
            yield at, length
        at += 12 + length


def unfilter(kind, row, before, size):
    """Undoes a PNG filter (ISO/IEC 15948, section 9)."""
    for i in range(len(row)) if kind else ():
        left = row[i - size] if i >= size else 0
        up = before[i]
        corner = before[i - size] if i >= size else 0
        if kind == 1:
            guess = left
        elif kind == 2:
            guess = up
        elif kind == 3:
            guess = (left + up) // 2
        else:
            guess = min((left, up, corner), key=lambda value: abs(left + up - corner - value))
        row[i] = (row[i] + guess) & 255


@unittest.skipUnless(CHROMIUM, "no chromium: apt-get install chromium")
class Chromium(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.mkdtemp(prefix="fransac_chromium_")
        cls.addClassCleanup(shutil.rmtree, cls.folder, ignore_errors=True)
        pages.synth(cls.folder, frames=2)
        cls.page = pages.report(cls.folder, "scenes", "--planes", "all", "--pictures", "1")

    def test_every_picture_and_plot_is_drawn(self):
        source = self.page.read_text(encoding="utf-8")
        copy = self.page.with_name("check.html")
        copy.write_text(source.replace("</body>", CHECK), encoding="utf-8")
        for width in (1280, 480):
            with self.subTest(width=width):
                dom = chromium(f"{self.folder}/profile", f"--window-size={width},900", "--dump-dom", copy.as_uri())
                seen = json.loads(html.unescape(re.search(r'<pre id="check">(.*?)</pre>', dom, re.S).group(1)))
                self.assertEqual(len(seen["images"]), source.count("<img "))
                for alt, complete, natural_width, natural_height, shown in seen["images"]:
                    self.assertTrue(complete and natural_width > 0 and natural_height > 0 and shown > 50, alt)
                self.assertEqual(len(seen["plots"]), 4)
                for title, plot_width, plot_height, misplaced in seen["plots"]:
                    self.assertGreater(plot_width, 400, title)
                    self.assertGreater(plot_height, 150, title)
                    self.assertEqual(misplaced, [], title)
                self.assertLessEqual(seen["overflow"], 0, "the page scrolls sideways")

    def test_screenshots_show_something(self):
        for name, scheme, width in (("light", 1, 1280), ("dark", 0, 1280), ("narrow", 1, 480)):
            with self.subTest(name):
                file = pathlib.Path(KEEP or self.folder, f"{name}.png")
                chromium(f"{self.folder}/profile", f"--window-size={width},2400", f"--screenshot={file}",
                         f"--force-device-scale-factor={1 if KEEP else 0.4}",  # pixels are decoded in Python
                         f"--blink-settings=preferredColorScheme={scheme}", self.page.as_uri())
                rows = pixels(file)
                flat = [colour for row in rows for colour in row]
                paper = collections.Counter(flat).most_common(1)[0][0]
                self.assertEqual(sum(paper) > 600, name != "dark", f"paper is {paper}")
                self.assertGreater(len(set(flat)), 200, "hardly any colours")
                self.assertGreater(sum(colour != paper for colour in flat), len(flat) / 10, "almost blank")


if __name__ == "__main__":
    unittest.main()
