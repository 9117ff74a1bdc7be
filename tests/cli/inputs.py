# SPDX-License-Identifier: Apache-2.0
"""Inputs of the golden cases, good and bad. Every function takes the case's folder and the words after `make KIND`."""
import json
import os
import struct
import zlib

PNG_SIGNATURE = b"\x89PNG\r\n\x1a\n"
WIDTH, HEIGHT = 64, 48
CAMERA = {"width": WIDTH, "height": HEIGHT, "fx": 60.0, "fy": 60.0, "cx": 31.5, "cy": 23.5, "depth_scale": 1000.0}


# Formats

def chunk(kind, data):
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def png_bytes(width, height, bits, values, header=None):
    """Grey; `header` may lie about the size."""
    kind = ">%dH" if bits == 16 else ">%dB"
    rows = [struct.pack(kind % width, *values[v * width:(v + 1) * width]) for v in range(height)]
    size = header or (width, height)
    return (PNG_SIGNATURE + chunk(b"IHDR", struct.pack(">IIBBBBB", *size, bits, 0, 0, 0, 0))
            + chunk(b"IDAT", zlib.compress(b"".join(b"\0" + row for row in rows))) + chunk(b"IEND", b""))


def png_chunks(data):
    at = len(PNG_SIGNATURE)
    while at < len(data):
        size, kind = struct.unpack(">I4s", data[at:at + 8])
        yield kind, data[at + 8:at + 8 + size]
        at += size + 12


def ply_column(data, name):
    """Values of a whole-number property of the vertices of a binary PLY as fransac writes it."""
    header, _, body = data.partition(b"end_header\n")
    properties = [line.split()[1:] for line in header.decode().splitlines() if line.startswith("property ")]
    codes = {"float": "f", "double": "d", "uchar": "B", "uint": "I"}
    vertex = struct.Struct("<" + "".join(codes[kind] for kind, _ in properties))
    place = [column for _, column in properties].index(name)
    return [values[place] for values in vertex.iter_unpack(body)]


def paeth(left, above, corner):
    """Of the three, the one next to left + above - corner (PNG specification, 9.4)."""
    return min((left, above, corner), key=lambda value: abs(left + above - corner - value))


def grey(data, bits):
    """Values of a grey PNG of 8 or 16 bits, row by row."""
    chunks = list(png_chunks(data))
    width, height, *kind = struct.unpack(">IIBB", chunks[0][1][:10])
    assert kind == [bits, 0], f"{kind[0]} bits, colour type {kind[1]}"
    packed = zlib.decompress(b"".join(content for kind, content in chunks if kind == b"IDAT"))
    size = bits // 8
    stride, values = size * width, []
    above = bytearray(stride)
    for v in range(height):
        start = v * (stride + 1)
        kind, row = packed[start], bytearray(packed[start + 1:start + 1 + stride])
        for i in range(stride):
            left, corner = (row[i - size], above[i - size]) if i >= size else (0, 0)
            predicted = (0, left, above[i], (left + above[i]) // 2, paeth(left, above[i], corner))[kind]
            row[i] = (row[i] + predicted) % 256
        values += struct.unpack(f">{width}{'H' if bits == 16 else 'B'}", row)
        above = row
    return values


def write(path, data):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(data if isinstance(data, bytes) else data.encode())


def write_frame(folder, depth, labels=None, camera=CAMERA):
    write(folder / "depth.png", png_bytes(WIDTH, HEIGHT, 16, depth))
    if camera is not None:
        write(folder / "camera.json", json.dumps(camera))
    if labels is not None:
        write(folder / "labels.png", png_bytes(WIDTH, HEIGHT, 8, labels))


def pcd_bytes(points, width=None, height=1, count=None):
    width = len(points) if width is None else width
    text = ("# .PCD v0.7\nVERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\n"
            f"WIDTH {width}\nHEIGHT {height}\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {count or len(points)}\nDATA ascii\n")
    return text + "".join(f"{x} {y} {z}\n" for x, y, z in points)


def ply_bytes(points, count=None):
    text = f"ply\nformat binary_little_endian 1.0\nelement vertex {count or len(points)}\n"
    text += "property float x\nproperty float y\nproperty float z\nend_header\n"
    return text.encode() + b"".join(struct.pack("<3f", *point) for point in points)


# Scenes

def scene():
    """A wall 2 m away with a box 1 m away in its middle and a column without depth: depth in mm, and labels."""
    depth, labels = [], []
    for v in range(HEIGHT):
        for u in range(WIDTH):
            box = 24 <= u < 40 and 18 <= v < 30
            depth.append(0 if u == 0 else 1000 if box else 2000)
            labels.append(0 if u == 0 else 255 if box else 1)
    return depth, labels


def plane_points(columns=30, rows=20, step=0.005):
    """A flat grid one metre away."""
    return [(column * step, row * step, 1.0) for row in range(rows) for column in range(columns)]


# Good inputs

def frame(folder, name):
    write_frame(folder / name, *scene())


def frame_with_regions(folder, name):
    """The wall is region 10 and the box 11, but for its left half, which is noise; with all planes as truth, label 1 alone is one."""
    depth, labels = scene()
    write_frame(folder / name, depth, labels)
    regions = [0 if depth[i] == 0 else 10 if labels[i] == 1 else 8 if i % WIDTH < 32 else 11 for i in range(WIDTH * HEIGHT)]
    write(folder / name / "gt_seg.png", png_bytes(WIDTH, HEIGHT, 8, regions))
    write(folder / name / "dataset.json", json.dumps({"truth": "planes"}))


def frame_with_ignored_wall(folder, name):
    """Nobody can judge the wall, the larger plane; the box is true plane 1."""
    depth, labels = scene()
    write_frame(folder / name, depth, [1 if label == 255 else 0 for label in labels])
    write(folder / name / "dataset.json", json.dumps({"truth": "planes"}))


def frame_without_truth(folder, name):
    write_frame(folder / name, scene()[0])


def dataset_with_floor(folder, name, floor):
    """The box's face is plane 2."""
    depth, labels = scene()
    write_frame(folder / name / "frame", depth, [2 if label == 255 else label for label in labels])
    write(folder / name / "dataset.json", json.dumps({"truth": "planes", "floor": json.loads(floor)}))


def dataset(folder, name, truth="dominant", frames="2"):
    for i in range(int(frames)):
        frame(folder, f"{name}/frame{i}")
    write(folder / name / "dataset.json", json.dumps({"truth": truth, "sensor": "none"}))


def sequence(folder, name):
    lines = ["# depth maps", "# timestamp filename"]
    for i in range(3):
        write(folder / name / "depth" / f"{i}.png", png_bytes(WIDTH, HEIGHT, 16, scene()[0]))
        lines.append(f"100.{i} depth/{i}.png")
    write(folder / name / "depth.txt", "\n".join(lines) + "\n")
    write(folder / name / "camera.json", json.dumps(CAMERA))


def associations(folder, name):
    sequence(folder, name)
    (folder / name / "depth.txt").unlink()
    write(folder / name / "associations.txt", "".join(f"100.{i} rgb/{i}.png 100.{i} depth/{i}.png\n" for i in range(3)))


def depth_of_metres(folder, name, scale="1.0"):
    """The scene as an array of floats, in metres times `scale`."""
    header = f"{{'descr': '<f4', 'fortran_order': False, 'shape': ({HEIGHT}, {WIDTH}), }}\n".encode()
    metres = [value / 1000.0 * float(scale) for value in scene()[0]]
    write(folder / name / "depth.npy", b"\x93NUMPY\1\0" + struct.pack("<H", len(header)) + header
          + struct.pack(f"<{len(metres)}f", *metres))
    write(folder / name / "camera.json", json.dumps(CAMERA))


def depth_pgm(folder, name):
    depth = scene()[0]
    write(folder / name, f"P5\n{WIDTH} {HEIGHT}\n65535\n".encode() + struct.pack(f">{len(depth)}H", *depth))


def sensor(folder, name, changes):
    """A sensor.json for frames of this size; `changes`: JSON, "width" is the distortion's."""
    changed = json.loads(changes)
    distortion = {"width": changed.pop("width", WIDTH), "height": HEIGHT, "offset_per_m": [0.01] + [0] * 24, "gain": [0] * 25}
    content = {"type": "fransac-sensor", "version": 1, "kind": "stereo", "distortion": distortion}
    write(folder / name, json.dumps({**content, **changed}))


def cloud_pcd(folder, name):
    write(folder / name, pcd_bytes(plane_points()))


def organised_pcd(folder, name):
    write(folder / name, pcd_bytes(plane_points(), 30, 20))


def cloud_with_viewpoint(folder, name, x, y, z):
    """The flat grid, seen from (x, y, z)."""
    write(folder / name, pcd_bytes(plane_points()).replace("VIEWPOINT 0 0 0", f"VIEWPOINT {x} {y} {z}"))


def cloud_with_box(folder, name, width=None, height=1):
    """The flat grid with 8 x 6 of its points 10 cm nearer."""
    points = [(x, y, 0.9 if 10 <= i % 30 < 18 and 7 <= i // 30 < 13 else z) for i, (x, y, z) in enumerate(plane_points())]
    write(folder / name, pcd_bytes(points, width and int(width), int(height)))


def cloud_ply(folder, name):
    write(folder / name, ply_bytes(plane_points()))


def plane_xyz(folder, name):
    """The flat grid in millimetres."""
    lines(folder, name, *(f"{1000 * x} {1000 * y} {1000 * z}" for x, y, z in plane_points()))


# Bad inputs

def text(folder, name, content=""):
    write(folder / name, content)


def lines(folder, name, *content):
    write(folder / name, "".join(f"{line}\n" for line in content))


def empty_folder(folder, name):
    (folder / name).mkdir()


def pipe(folder, name):
    (folder / name).unlink(missing_ok=True)
    os.mkfifo(folder / name)


def link(folder, target, name):
    (folder / name).unlink(missing_ok=True)
    (folder / name).symlink_to(target)


def frame_with_name(folder, name):
    """A frame that cannot be read, in a folder that forges a line of its own."""
    write(folder / name / "a\nfransac: forged\x1b[31m" / "depth.png", "no picture")
    write(folder / name / "dataset.json", "{}")


def frame_with_long_field(folder, name):
    field = "x" * 400000
    frame_with_camera_text(folder, name, f'{{"{field}": 1, "{field}": 2}}')


def read_only(folder, name):
    write(folder / name, "precious")
    (folder / name).chmod(0o444)


def truncated_frame(folder, name):
    frame(folder, name)
    data = (folder / name / "depth.png").read_bytes()
    write(folder / name / "depth.png", data[:len(data) // 2])


def hostile_frame(folder, name, width, height):
    frame(folder, name)
    write(folder / name / "depth.png", png_bytes(4, 4, 16, [1000] * 16, header=(int(width), int(height))))


def frame_8_bit(folder, name):
    frame(folder, name)
    write(folder / name / "depth.png", png_bytes(WIDTH, HEIGHT, 8, [100] * WIDTH * HEIGHT))


def frame_without_camera(folder, name):
    write_frame(folder / name, scene()[0], camera=None)


def frame_with_camera(folder, name, changes):
    """`changes`: JSON; null removes a field."""
    camera = {key: value for key, value in {**CAMERA, **json.loads(changes)}.items() if value is not None}
    write_frame(folder / name, *scene(), camera=camera)


def frame_with_camera_text(folder, name, content):
    write_frame(folder / name, *scene())
    write(folder / name / "camera.json", content)


def frame_with_labels_of_another_size(folder, name):
    frame(folder, name)
    write(folder / name / "labels.png", png_bytes(2, 2, 8, [1] * 4))


def frame_with_regions_of_another_size(folder, name):
    frame(folder, name)
    write(folder / name / "gt_seg.png", png_bytes(2, 2, 8, [10] * 4))


def frame_with_points(folder, name, *pixels):
    """No depth but at these pixels, "u,v" each: 1 m."""
    depth = [0] * (WIDTH * HEIGHT)
    for pixel in pixels:
        u, v = map(int, pixel.split(","))
        depth[v * WIDTH + u] = 1000
    write_frame(folder / name, depth)


def collinear_frame(folder, name):
    frame_with_points(folder, name, *[f"{u},20" for u in range(5, 60)])


def noise_frame(folder, name):
    """Depth so scattered that no plane holds a fifth of it."""
    state, depth = 1, []
    for _ in range(WIDTH * HEIGHT):
        state = (state * 1103515245 + 12345) % 2**31
        depth.append(500 + (state >> 8) % 3500)
    write_frame(folder / name, depth)


def frame_with_cut_off_picture(folder, name):
    frame(folder, name)
    write(folder / name / "rgb.jpg", b"\xff\xd8\xff\xe0\x00\x10JFIF\x00\x01\x01\x00")


def dataset_with_broken_frame(folder, name):
    dataset(folder, name, frames="3")
    write(folder / name / "frame1" / "depth.png", b"no picture")


def nan_pcd(folder, name):
    write(folder / name, pcd_bytes([("nan", "nan", "nan")] * 50))


def inf_pcd(folder, name):
    write(folder / name, pcd_bytes([("inf", "0", "-inf")] * 50))


def pcd_with_holes(folder, name):
    points = plane_points()
    points[0] = points[100] = ("nan", "nan", "nan")
    points[1] = ("inf", "0", "1")
    write(folder / name, pcd_bytes(points))


def one_point_pcd(folder, name):
    write(folder / name, pcd_bytes([(0, 0, 1)]))


def same_point_pcd(folder, name):
    write(folder / name, pcd_bytes([(0.5, 0.5, 1)] * 100))


def collinear_pcd(folder, name):
    write(folder / name, pcd_bytes([(0.05 * i, 0.1 * i, 1) for i in range(100)]))


def coarse_pcd(folder, name):
    """A sphere's surface in millimetres: no plane within 1 cm."""
    state, points = 1, []
    for _ in range(2000):
        xyz = []
        for _ in range(3):
            state = (state * 1103515245 + 12345) % 2**31
            xyz.append((state >> 8) % 4000 - 2000)
        points.append(tuple(xyz))
    write(folder / name, pcd_bytes(points))


def truncated_pcd(folder, name):
    write(folder / name, pcd_bytes(plane_points())[:700])


def hostile_pcd(folder, name):
    write(folder / name, pcd_bytes(plane_points(), 4000000000, 1000, 4000000000000))


def pcd_without_z(folder, name):
    write(folder / name, "VERSION 0.7\nFIELDS x y\nSIZE 4 4\nTYPE F F\nCOUNT 1 1\nWIDTH 2\nHEIGHT 1\n"
                         "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 2\nDATA ascii\n0 0\n1 1\n")


def truncated_ply(folder, name):
    write(folder / name, ply_bytes(plane_points())[:1000])


def hostile_ply(folder, name):
    write(folder / name, ply_bytes(plane_points(), 2**40))


def sequence_with_bad_line(folder, name):
    sequence(folder, name)
    write(folder / name / "depth.txt", "# comment\n100.0 depth/0.png\nnot-a-time depth/1.png\n")
