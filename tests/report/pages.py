# SPDX-License-Identifier: Apache-2.0
"""Pages to look at. Environment: FRANSAC_APP, the program."""

import json
import os
import pathlib
import struct
import subprocess
import xml.etree.ElementTree as xml
import zlib

METHODS = ("cells", "ransac", "rransac", "voxel-ransac", "fransac")


def fransac(folder, *arguments):
    """Runs the program and returns what it printed."""
    return subprocess.run([os.environ["FRANSAC_APP"], *arguments], cwd=folder, check=True, capture_output=True, text=True).stdout


def synth(folder, name="scenes", scene="desk", frames=2):
    fransac(folder, "synth", name, "--scene", scene, "--frames", str(frames), "--width", "160", "--height", "120", "--seed", "3")


def walk(folder, name="walk", scene="empty_room", frames=30):
    fransac(folder, "synth", name, "--scene", scene, "--frames", str(frames), "--motion", "walk", "--width", "160", "--height", "120",
            "--seed", "3")


def change_truth(folder, truth, name="scenes"):
    path = pathlib.Path(folder, name, "dataset.json")
    path.write_text(json.dumps({**json.loads(path.read_text(encoding="utf-8")), "truth": truth}), encoding="utf-8")


def report(folder, *arguments, out="page"):
    """Writes a page and returns its path."""
    fransac(folder, "report", *arguments, "--out", out, "--repeat", "1")
    return pathlib.Path(folder, out, "index.html")


def parse(path):
    """As XML, which is stricter than HTML: every element closed, every attribute quoted, nothing left unescaped."""
    return xml.parse(path).getroot()


def with_class(root, name):
    return [element for element in root.iter() if name in element.get("class", "").split()]


def text(element):
    return "".join(element.itertext()).strip()


def pixels(data, step=1):
    """Rows of (r, g, b), or (grey,), of an 8-bit PNG, or every `step`-th row and column."""
    width, height, bits, kind = struct.unpack(">IIBB", data[16:26])
    size = {0: 1, 2: 3, 6: 4}[kind]
    assert bits == 8
    packed = b"".join(data[at + 8:at + 8 + length] for at, length in chunks(data, b"IDAT"))
    raw = zlib.decompress(packed)
    stride = width * size
    before = bytearray(stride)
    rows = []
    for v in range(height):
        row = bytearray(raw[v * (stride + 1) + 1:(v + 1) * (stride + 1)])
        unfilter(raw[v * (stride + 1)], row, before, size)
        before = row
        if v % step == 0:
            rows.append([tuple(row[u * size:u * size + min(size, 3)]) for u in range(0, width, step)])
    return rows


def write_grey(path, width, height, values):
    """An 8-bit grey PNG."""
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    rows = b"".join(b"\0" + values[v * width:(v + 1) * width] for v in range(height))
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)) +
                     chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


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
