"""Scan files in the exact layout of each format, written from a made-up face.

Every writer returns {name: bytes}, the scan first and then the files that belong beside it.
The quirks are those that real files have: CRLF, comments, extra columns, missing blocks, …
"""

import gzip
import io
import json
import struct
import zlib

import numpy as np

from rangeface.io import mcap, png16
from rangeface.io._mcap_writer import encode
from rangeface.types import Pinhole, RangeImage

CAMERA = Pinhole(fx=180.0, fy=182.0, cx=12.3, cy=14.6, width=26, height=30)


def face(rows=30, columns=26, pitch=4.0):
    """Grid (H, W, 3) of a face-like relief: mm, x right, y up, z towards the viewer, z < 0."""
    y, x = np.mgrid[:rows, :columns].astype(float)
    x, y = (x - (columns - 1) / 2) * pitch, ((rows - 1) / 2 - y) * pitch
    u, v = x / (columns * pitch / 2), y / (rows * pitch / 2)
    z = -700.0 - 45.0 * u**2 - 30.0 * v**2 + 22.0 * np.exp(-((x / 12) ** 2) - ((y / 18) ** 2))
    return np.where((u**2 + v**2 < 0.95)[..., None], np.stack([x, y, z], -1), np.nan)


def points_and_triangles(grid):
    valid = np.isfinite(grid[..., 2])
    number = np.where(valid, np.cumsum(valid).reshape(valid.shape) - 1, -1)
    a, b, c, d = number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]
    quads = np.stack([a, d, c, b], -1).reshape(-1, 4)
    quads = quads[(quads >= 0).all(1)]
    return grid[valid], np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]]), quads


def depth(camera=CAMERA):
    """Depth image (H, W), mm, 0 where invalid."""
    v, u = np.mgrid[: camera.height, : camera.width].astype(float)
    r2 = ((u - camera.cx) / 10) ** 2 + ((v - camera.cy) / 12) ** 2
    return np.where(r2 < 1, 650 + 40 * r2 - 20 * np.exp(-8 * r2), 0.0)


def camera_toml(unit='depth_unit = "0.1mm"', camera=CAMERA):
    names = ("fx", "fy", "cx", "cy", "width", "height")
    return "\n".join([*(f"{n} = {getattr(camera, n)}" for n in names), unit, ""]).encode()


# ── meshes and clouds ────────────────────────────────────────────────────────────────────


def _lines(rows, end="\n"):
    return end.join(rows).encode()


def gavab(grid=None):
    """VRML 1.0 as GavabDB writes it: a display scale, quads and triangles, commas."""
    points, triangles, quads = points_and_triangles(face() if grid is None else grid)
    half = len(quads) // 2
    faces = [",".join(map(str, q)) + ",-1" for q in quads[:half]]
    faces += [",".join(map(str, t)) + ",-1" for t in triangles[half : len(quads)]]
    faces += [",".join(map(str, t)) + ",-1" for t in triangles[len(quads) + half :]]
    text = "#VRML V1.0 ascii\n\nSeparator {\n  Transform { scaleFactor 0.5 0.5 0.5 }\n"
    text += '  Info { string "a { brace, and a \\" quote" }\n'
    text += "  ShapeHints { vertexOrdering COUNTERCLOCKWISE shapeType UNKNOWN_SHAPE_TYPE }\n"
    text += "  Coordinate3 {\n    point [\n"
    text += ",\n".join(f"      {x:.5f} {y:.5f} {z:.5f}" for x, y, z in points)
    text += "\n    ]\n  }\n  IndexedFaceSet {\n    coordIndex [\n" + ",\n".join(faces)
    return {"cara1_frontal1.wrl": (text + "\n    ]\n  }\n}\n").encode()}


def vrml2(grid=None):
    """VRML 2.0 with nested transforms, DEF and USE, comments and CRLF."""
    points, triangles, _ = points_and_triangles(face() if grid is None else grid)
    moved = (points - [10.0, -20.0, 30.0])[:, [1, 0, 2]] * [1, -1, 1] / 2.0
    rows = ["#VRML V2.0 utf8", "# a comment with { and [", 'NavigationInfo { type [ "EXAMINE" ] }']
    rows += ["DEF Head Transform {", "  translation 10 -20 30", "  children ["]
    rows += ["    Transform { rotation 0 0 1 1.5707963267948966 scale 2 2 2 children [ Shape {"]
    rows += ["      appearance Appearance { material Material { diffuseColor .8 .7 .6 }"]
    rows += ['        texture ImageTexture { url "face.png" } }']
    rows += [
        "      geometry IndexedFaceSet { solid FALSE",
        "        coord DEF C Coordinate { point [",
    ]
    rows += [f"{x:.6e} {y:.6e} {z:.6e}, # point" for x, y, z in moved]
    rows += ["        ] }", "        coordIndex ["]
    rows += [f"          {a}, {b}, {c}, -1," for a, b, c in triangles]
    rows += ["        ] } } ] }", "    Transform { rotation 0 0 1 1.5707963267948966 scale 2 2 2"]
    rows += ["      children Shape { geometry PointSet { coord USE C } } }", "  ]", "}", ""]
    return {"F0001_NE00WH_F3D.wrl": _lines(rows, "\r\n")}


def _ply_header(kind, points, faces, *, extra=(), end="\n", count_type="uchar"):
    rows = ["ply", f"format {kind} 1.0", "comment made by a test", "obj_info nothing"]
    rows += [f"element vertex {len(points)}", "property float x", "property float y"]
    rows += ["property float z", *extra]
    if faces is not None:
        rows += [f"element face {len(faces)}", f"property list {count_type} int vertex_indices"]
    return _lines([*rows, "end_header", ""], end)


def ply_ascii(grid=None):
    """PLY ascii with CRLF, colours and mixed polygons."""
    points, triangles, quads = points_and_triangles(face() if grid is None else grid)
    faces = [*quads[: len(quads) // 2], *triangles[len(quads) // 2 : len(quads)]]
    faces += [*triangles[len(quads) + len(quads) // 2 :]]
    extra = ("property uchar red", "property uchar green")
    rows = [f"{x:.9g} {y:.9g} {z:.9g} 200 180" for x, y, z in points]
    rows += [" ".join(map(str, [len(f), *f])) for f in faces]
    head = _ply_header("ascii", points, faces, extra=extra, end="\r\n")
    return {"a.ply": head + _lines([*rows, ""], "\r\n")}


def ply_binary(grid=None, order="<"):
    """PLY binary with a double quality column, mixed polygons and a trailing element."""
    points, triangles, quads = points_and_triangles(face() if grid is None else grid)
    kind = "binary_little_endian" if order == "<" else "binary_big_endian"
    row = np.dtype([("p", order + "f4", 3), ("q", order + "f8")])
    table = np.zeros(len(points), row)
    table["p"] = points
    faces = [*quads, *triangles[:5]]
    body = b"".join(struct.pack(f"{order}B{len(f)}i", len(f), *map(int, f)) for f in faces)
    head = _ply_header(kind, points, faces, extra=("property double quality",))
    head = head.replace(b"end_header", b"element edge 1\nproperty int vertex1\nend_header")
    return {"b.ply": head + table.tobytes() + body + struct.pack(order + "i", 0)}


def ply_big(grid=None):
    return ply_binary(grid, order=">")


def ply_grid(grid=None):
    """A range grid as the Stanford and CyberWare scanners write it."""
    grid = face() if grid is None else grid
    points, _, _ = points_and_triangles(grid)
    valid = np.isfinite(grid[..., 2]).ravel()
    rows = ["ply", "format ascii 1.0", f"obj_info num_cols {grid.shape[1]}"]
    rows += [f"obj_info num_rows {grid.shape[0]}", f"element vertex {len(points)}"]
    rows += ["property float x", "property float y", "property float z"]
    rows += [f"element range_grid {valid.size}", "property list uchar int vertex_indices"]
    rows += ["end_header", *(f"{x:.6f} {y:.6f} {z:.6f}" for x, y, z in points)]
    number = iter(range(len(points)))
    rows += [f"1 {next(number)}" if full else "0" for full in valid]
    return {"grid.ply": _lines([*rows, ""])}


def obj(grid=None):
    """OBJ with colours on the vertices, negative indices, textures and a continued line."""
    points, _, quads = points_and_triangles(face() if grid is None else grid)
    rows = ["# made by a test", "mtllib a.mtl", "o face", "g skin"]
    rows += [f"v {x:.6f} {y:.6f} {z:.6f} 0.5 0.5 0.5" for x, y, z in points]
    rows += ["vt 0.5 0.5", "vn 0 0 1", "s off", "usemtl skin"]
    n = len(points)
    third = len(quads) // 3
    rows += ["f " + " ".join(f"{i + 1}/1/1" for i in q) for q in quads[:third]]
    rows += ["f " + " ".join(f"{i - n}//-1" for i in q) for q in quads[third : 2 * third]]
    rows += ["f \\", " ".join(str(i + 1) for i in quads[2 * third])]
    rows += ["f " + " ".join(str(i + 1) for i in q) for q in quads[2 * third + 1 :]]
    return {"a.obj": _lines([*rows, ""])}


def off(grid=None):
    """COFF: colours on vertices and faces, comments, the counts on a line of their own."""
    points, _, quads = points_and_triangles(face() if grid is None else grid)
    rows = ["COFF", "# comment", f"{len(points)} {len(quads)} 0", ""]
    rows += [f"{x:.6f} {y:.6f} {z:.6f} 200 180 170 255" for x, y, z in points]
    rows += ["4 " + " ".join(map(str, q)) + " 10 20 30" for q in quads]
    return {"a.off": _lines([*rows, ""])}


def stl_binary(grid=None):
    """Binary STL whose comment begins with "solid"."""
    points, triangles, _ = points_and_triangles(face() if grid is None else grid)
    row = np.dtype([("n", "<f4", 3), ("c", "<f4", (3, 3)), ("a", "<u2")])
    table = np.zeros(len(triangles), row)
    table["c"] = points[triangles]
    head = b"solid by an exporter".ljust(80) + struct.pack("<I", len(table))
    return {"a.stl": head + table.tobytes()}


def stl_ascii(grid=None):
    points, triangles, _ = points_and_triangles(face() if grid is None else grid)
    rows = ["solid face"]
    for triangle in triangles:
        rows += ["  facet normal 0 0 1", "    outer loop"]
        rows += ["      vertex {:.6e} {:.6e} {:.6e}".format(*points[i]) for i in triangle]
        rows += ["    endloop", "  endfacet"]
    return {"ascii.stl": _lines([*rows, "endsolid face", ""])}


def _pcd_header(count, height, data, fields="x y z rgb", kinds="F F F F"):
    n = len(fields.split())
    return _lines([
        "# .PCD v0.7 - Point Cloud Data file format", "VERSION 0.7", f"FIELDS {fields}",
        "SIZE" + " 4" * n, f"TYPE {kinds}", "COUNT" + " 1" * n, f"WIDTH {count // height}",
        f"HEIGHT {height}", "VIEWPOINT 0 0 0 1 0 0 0", f"POINTS {count}", f"DATA {data}", "",
    ])  # fmt: skip


def _pcd_points():
    """Organised cloud of a pinhole camera, metres, NaN where invalid."""
    z = np.where(depth() > 0, depth() / 1000, np.nan)
    v, u = np.mgrid[: CAMERA.height, : CAMERA.width]
    x, y = (u - CAMERA.cx) / CAMERA.fx * z, (v - CAMERA.cy) / CAMERA.fy * z
    return np.stack([x, y, z, np.zeros_like(z)], -1).astype("<f4")


def pcd_ascii():
    points = _pcd_points().reshape(-1, 4)
    head = _pcd_header(len(points), CAMERA.height, "ascii")
    return {"a.pcd": head + _lines([*(" ".join(f"{c:.8g}" for c in p) for p in points), ""])}


def pcd_binary():
    points = _pcd_points()
    head = _pcd_header(points.size // 4, CAMERA.height, "binary")
    return {"b.pcd": head + points.tobytes()}


def pcd_compressed():
    points = _pcd_points()
    raw = np.ascontiguousarray(points.reshape(-1, 4).T).tobytes()
    packed = lzf(raw)
    head = _pcd_header(points.size // 4, CAMERA.height, "binary_compressed")
    return {"c.pcd": head + struct.pack("<II", len(packed), len(raw)) + packed}


def lzf(raw):
    """A plain LZF encoder: literals, and runs where four bytes came before."""
    out, seen, i, literal = bytearray(), {}, 0, bytearray()

    def flush():
        for k in range(0, len(literal), 32):
            piece = literal[k : k + 32]
            out.append(len(piece) - 1)
            out.extend(piece)
        literal.clear()

    while i < len(raw):
        key = raw[i : i + 4]
        back = i - seen.get(key, -9999)
        seen[key] = i
        length = 0
        while back <= 8191 and length < 264 and i + length < len(raw) and (
            raw[i + length] == raw[i + length - back]
        ):  # fmt: skip
            length += 1
        if length < 4:
            literal.append(raw[i])
            i += 1
            continue
        flush()
        code, distance = length - 2, back - 1
        if code < 7:
            out.append(code << 5 | distance >> 8)
        else:
            out.extend((7 << 5 | distance >> 8, code - 7))
        out.append(distance & 255)
        i += length
    flush()
    return bytes(out)


def xyz(grid=None):
    points, _, _ = points_and_triangles(face() if grid is None else grid)
    rows = ["# x y z intensity", *(f"{x:.5f}\t{y:.5f}\t{z:.5f}\t0.5" for x, y, z in points)]
    return {"a.xyz": _lines([*rows, ""])}


def csv(grid=None):
    points, _, _ = points_and_triangles(face() if grid is None else grid)
    rows = ["X;Y;Z", *(f"{x:.5f};{y:.5f};{z:.5f}" for x, y, z in points)]
    return {"a.csv": _lines([*rows, ""], "\r\n")}


# ── grids of the databases ───────────────────────────────────────────────────────────────


def bnt(grid=None):
    grid = face() if grid is None else grid
    rows, columns = grid.shape[:2]
    planes = np.zeros((5, rows, columns))
    planes[:3] = np.where(np.isfinite(grid), grid, -1e9).transpose(2, 0, 1)[:, ::-1]
    name = b"bs000_N_N_0.png"
    head = struct.pack("<HHdH", rows, columns, -1e9, len(name)) + name
    return {
        "bs000_N_N_0.bnt": head + struct.pack("<I", planes.size) + planes.astype("<f8").tobytes()
    }


def abs_text(grid=None, *, invalid=-999999.0, spaced=False):
    grid = face() if grid is None else grid
    flag = np.isfinite(grid[..., 2])
    rows = [f"{grid.shape[0]} rows", f"{grid.shape[1]} columns", "pixels (flag X Y Z):"]
    if spaced:
        rows = [
            f"  {grid.shape[0]}   rows ",
            f" {grid.shape[1]}  columns",
            "pixels  ( flag X  Y Z ) :",
        ]
    planes = np.where(flag[..., None], grid, invalid)
    rows += [" ".join(map(str, flag.astype(int).ravel()))]
    rows += [" ".join(f"{v:.6f}" for v in planes[..., k].ravel()) for k in range(3)]
    return {"02463d452.abs": _lines([*rows, ""], "\r\n" if spaced else "\n")}


def abs_gz(grid=None):
    plain = abs_text(grid, invalid=0.0, spaced=True)["02463d452.abs"]
    return {"02463d453.abs.gz": gzip.compress(plain, mtime=0)}


# ── depth images ─────────────────────────────────────────────────────────────────────────


def rap3df():
    v, u = np.mgrid[:149, :119].astype(float)
    r2 = ((u - 59) / 45) ** 2 + ((v - 70) / 60) ** 2
    z = np.where(r2 < 1, 700 + 90 * r2 - 25 * np.exp(-20 * r2), 0)
    byte = np.where(z > 0, _byte2(z), 0)
    amplitude = np.where(z > 0, 900 * np.exp(-2 * r2), 0)
    return {
        "k1_box_xyz_depth.data": byte.astype("<u2").tobytes(),
        "k1_box_xyz_ir.data": np.where(z > 0, _byte2(amplitude), 0).astype("<u2").tobytes(),
    }


def _byte2(values):
    return (np.ascontiguousarray(values, "<f4").view("<u4") >> 16) & 255


def png():
    pixels = np.rint(depth() * 10).astype(np.uint16)
    return {"a.png": png16.encode(pixels), "a.toml": camera_toml()}


def truedepth():
    """Tenths of a millimetre; intrinsics as columns; wrong reference dimensions."""
    K = [[CAMERA.fx, 0, 0], [0, CAMERA.fy, 0], [CAMERA.cx, CAMERA.cy, 1]]
    facts = {"calibration_data": {"intrinsic_matrix": K,
             "intrinsic_matrix_reference_dimension_width": 3088}}  # fmt: skip
    pixels = np.rint(depth() * 10).astype(np.uint16)
    return {"f.png": png16.encode(pixels), "f.json": json.dumps(facts).encode()}


def tiff(compression=1, order="<", dtype="u2", rows_per_strip=7, predictor=1):
    values = depth() * 10 if dtype == "u2" else depth() / 1000
    image = np.rint(values).astype(np.uint16) if dtype == "u2" else values.astype(np.float32)
    image = image.astype(order + dtype)
    if predictor == 2:
        image = np.concatenate([image[:, :1], np.diff(image.astype("u2"), axis=1)], 1).astype(
            order + "u2"
        )
    strips = [image[k : k + rows_per_strip].tobytes() for k in range(0, len(image), rows_per_strip)]
    if compression == 8:
        strips = [zlib.compress(s) for s in strips]
    elif compression == 5:
        strips = [tiff_lzw(s) for s in strips]
    elif compression == 32773:
        strips = [packbits(s) for s in strips]
    offsets = np.cumsum([8, *map(len, strips)])
    tags = [(256, 3, [image.shape[1]]), (257, 3, [image.shape[0]]), (258, 3, [8 * image.itemsize]),
            (259, 3, [compression]), (262, 3, [1]), (273, 4, offsets[:-1]), (277, 3, [1]),
            (278, 3, [rows_per_strip]), (279, 4, [len(s) for s in strips]), (317, 3, [predictor]),
            (339, 3, [1 if dtype == "u2" else 3])]  # fmt: skip
    start = int(offsets[-1]) + int(offsets[-1]) % 2
    body, after = b"", start + 2 + 12 * len(tags) + 4
    tail = b""
    for tag, kind, values in tags:
        packed = np.asarray(values).astype(order + {3: "u2", 4: "u4"}[kind]).tobytes()
        if len(packed) > 4:
            field = struct.pack(order + "I", after + len(tail))
            tail += packed
        else:
            field = packed.ljust(4, b"\0")
        body += struct.pack(order + "HHI", tag, kind, len(values)) + field
    head = (b"II*\0" if order == "<" else b"MM\0*") + struct.pack(order + "I", start)
    data = (head + b"".join(strips)).ljust(start, b"\0")
    data += struct.pack(order + "H", len(tags)) + body + bytes(4) + tail
    unit = 'depth_unit = "0.1mm"' if dtype == "u2" else 'depth_unit = "m"'
    return {"a.tif": data, "a.toml": camera_toml(unit)}


def packbits(raw):
    out = bytearray()
    for k in range(0, len(raw), 100):
        piece = raw[k : k + 100]
        if len(set(piece)) == 1:
            out += bytes([257 - len(piece) if len(piece) > 1 else 0, piece[0]])
        else:
            out += bytes([len(piece) - 1]) + piece
    return bytes(out)


def tiff_lzw(raw):
    """TIFF 6.0, section 13, as written there."""
    out, acc, bits = bytearray(), 0, 0
    table, width = {bytes([k]): k for k in range(256)}, 9
    following = 258

    def put(code):
        nonlocal acc, bits
        acc, bits = acc << width | code, bits + width
        while bits >= 8:
            out.append(acc >> (bits - 8) & 255)
            bits -= 8

    put(256)
    word = b""
    for value in raw:
        longer = word + bytes([value])
        if longer in table:
            word = longer
            continue
        put(table[word])
        table[longer] = following
        following += 1
        if following == 4094:
            put(256)
            table, width, following = {bytes([k]): k for k in range(256)}, 9, 258
        elif following >= 1 << width and width < 12:
            width += 1
        word = bytes([value])
    if word:
        put(table[word])
    put(257)
    out.append(acc << (8 - bits) & 255 if bits else 0)
    return bytes(out)


def tiff_lzw_file():
    return tiff(compression=5, order=">")


def tiff_deflate():
    return tiff(compression=8, dtype="f4")


def npz():
    buffer = io.BytesIO()
    z = np.where(depth() > 0, depth(), np.nan).astype(np.float32)
    values = [CAMERA.fx, CAMERA.fy, CAMERA.cx, CAMERA.cy]
    np.savez_compressed(buffer, depth=z, camera=values, sigma=np.full(z.shape, 2.0))
    return {"a.npz": buffer.getvalue()}


def biwi():
    z = depth().astype("<i2").ravel()
    out = struct.pack("<ii", CAMERA.width, CAMERA.height)
    i = 0
    while i < len(z):
        empty = 0
        while i + empty < len(z) and z[i + empty] == 0:
            empty += 1
        full = 0
        while i + empty + full < len(z) and z[i + empty + full]:
            full += 1
        out += struct.pack("<ii", empty, full) + z[i + empty : i + empty + full].tobytes()
        i += empty + full
    cal = f"{CAMERA.fx} 0 {CAMERA.cx} \n0 {CAMERA.fy} {CAMERA.cy} \n0 0 1 \n\n0 0 0 0 \n"
    return {"frame_00003_depth.bin": out, "depth.cal": cal.encode()}


def swissranger(titles=("Calibrated Distance", "Calibrated xVector", "Calibrated yVector",
                        "Amplitude", "Confidence map"), rows=144, columns=176):  # fmt: skip
    v, u = np.mgrid[:rows, :columns].astype(float)
    z = 0.4 + 0.05 * ((u - 88) / 88) ** 2 + 0.03 * ((v - 72) / 72) ** 2
    planes = {"dist": z, "xvec": (u - 87.5) / 200 * z, "yvec": (v - 71.5) / 200 * z,
              "ampl": 2000 * np.exp(-(((u - 88) / 80) ** 2)),
              "conf": np.full_like(z, 255)}  # fmt: skip
    out = []
    for title in titles:
        plane = next(p for key, p in planes.items() if key in title.lower().replace(" ", ""))
        out += [f"% {title}", *(" ".join(f"{c:.7g}" for c in row) for row in plane)]
    return {"sr.dat": _lines([*out, ""], "\r\n")}


def vap():
    z = np.where((np.arange(640 * 480) % 7 == 0), -1, 700 + np.arange(640 * 480) % 50)
    return {"v.dat": _lines([" ".join(map(str, row)) for row in z.reshape(480, 640)])}


def recording():
    z = np.where(depth() > 0, depth(), np.nan)
    frames = [RangeImage(z + k, CAMERA) for k in range(3)]
    return {"r.mcap": encode(frames)}


def recording_chunked(packing=""):
    """The same records in a chunk, and a ROS 1 image of 16 bits."""
    plain = recording()["r.mcap"][8:-8]
    records, at = [], 0
    while at < len(plain):
        size = 9 + struct.unpack_from("<Q", plain, at + 1)[0]
        records.append(plain[at : at + size])
        at += size
    inner = b"".join(r for r in records if r[0] in (3, 4, 5))
    packed = inner
    if packing == "zstd":
        import zstandard

        packed = zstandard.compress(inner)
    elif packing == "lz4":
        import lz4.frame

        packed = lz4.frame.compress(inner)
    name = struct.pack("<I", len(packing)) + packing.encode()
    chunk = (
        struct.pack("<QQQI", 0, 1, len(inner), 0) + name + struct.pack("<Q", len(packed)) + packed
    )
    chunk = struct.pack("<BQ", 6, len(chunk)) + chunk
    return {"c.mcap": mcap.MAGIC + records[0] + chunk + b"".join(records[-2:]) + mcap.MAGIC}


def recording_compressed_images(pixels, *, ros1):
    """One sensor_msgs/CompressedImage of ROS 1 or ROS 2."""

    def text(word, *, cdr=False):
        data = word.encode() + (b"\0" if cdr else b"")
        return struct.pack("<I", len(data)) + data

    def record(kind, body):
        return struct.pack("<BQ", kind, len(body)) + body

    body = bytes(12) if ros1 else bytes(8)  # sequence and stamp
    for word in ("depth", "16UC1; compressedDepth png"):
        body += text(word, cdr=not ros1)
        body += b"" if ros1 else bytes(-len(body) % 4)
    data = bytes(12) + png16.encode(pixels)
    body += struct.pack("<I", len(data)) + data
    name = "sensor_msgs/CompressedImage" if ros1 else "sensor_msgs/msg/CompressedImage"
    kind = "ros1" if ros1 else "cdr"
    schema = record(3, struct.pack("<H", 1) + text(name) + text(f"{kind}msg") + text(""))
    head = struct.pack("<HH", 1, 1) + text("/depth") + text(kind) + struct.pack("<I", 0)
    message = struct.pack("<HIQQ", 1, 0, 0, 0) + (b"" if ros1 else b"\0\1\0\0") + body
    return {"z.mcap": mcap.MAGIC + schema + record(4, head) + record(5, message) + mcap.MAGIC}


#: Everything that is a scan, by a name of its own.
FILES = {
    f.__name__: f
    for f in (
        gavab, vrml2, ply_ascii, ply_binary, ply_big, ply_grid, obj, off, stl_binary, stl_ascii,
        pcd_ascii, pcd_binary, pcd_compressed, xyz, csv, bnt, abs_text, abs_gz, rap3df, png,
        truedepth, tiff, tiff_lzw_file, tiff_deflate, npz, biwi, swissranger, vap, recording,
        recording_chunked,
    )
}  # fmt: skip

CLOUDS = (gavab, vrml2, ply_ascii, ply_binary, ply_big, obj, off, stl_binary, stl_ascii, xyz, csv)
GRIDS = (bnt, abs_text, abs_gz, ply_grid)
DEPTHS = (png, truedepth, tiff, tiff_lzw_file, tiff_deflate, npz, biwi, recording,
          recording_chunked, pcd_ascii, pcd_binary, pcd_compressed)  # fmt: skip


def write(files, folder):
    """Write the files and return the path of the scan."""
    for name, data in files.items():
        (folder / name).write_bytes(data)
    return folder / next(iter(files))
