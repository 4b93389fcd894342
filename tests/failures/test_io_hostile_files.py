"""Files that lie about themselves: each is refused with one line, at once and in little memory."""

import contextlib
import gzip
import io as streams
import resource
import struct
import time
import zipfile
import zlib

import numpy as np
import pytest
import scan_files as files

from rangeface import io
from rangeface.errors import ParameterError, ScanError, ScanFault, UnitError
from rangeface.io import mcap
from rangeface.types import Orthographic, PointSet, RangeImage

HUGE = 2**31 - 1
PLY = "ply\nformat {kind} 1.0\nelement vertex {n}\n"
PLY += "property float x\nproperty float y\nproperty float z\n"
TRIANGLE = "0 0 0\n90 0 0\n0 90 0\n"


def chunk(kind, body):
    return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))


def png(width, height, body=b"", bits=16, colour=0, interlace=0, extra=b""):
    head = struct.pack(">IIBBBBB", width, height, bits, colour, 0, 0, interlace)
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + extra
            + chunk(b"IDAT", body) + chunk(b"IEND", b""))  # fmt: skip


def ply(rest, n=3, kind="ascii"):
    return PLY.format(kind=kind, n=n).encode() + rest


def npy(shape, body=b"", descr="<f4"):
    head = f"{{'descr': '{descr}', 'fortran_order': False, 'shape': {shape}, }}\n".encode()
    return b"\x93NUMPY\x01\0" + struct.pack("<H", len(head)) + head + body


def npz(**entries):
    out = streams.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in entries.items():
            archive.writestr(f"{name}.npy", data)
    return out.getvalue()


def tiff(**tags):
    names = {"width": 256, "height": 257, "bits": 258, "packing": 259, "offset": 273,
             "rows": 278, "count": 279, "samples": 277, "format": 339,
             "tile_w": 322, "tile_h": 323, "tiles": 324, "tile_counts": 325}  # fmt: skip
    tags = {"width": 4, "height": 4, "bits": 16, "packing": 1, "offset": 8, "count": 32} | tags
    rows = sorted((names[name], value) for name, value in tags.items())
    body = b"".join(struct.pack("<HHII", tag, 4, 1, value % 2**32) for tag, value in rows)
    return b"II*\0" + struct.pack("<I", 8) + struct.pack("<H", len(rows)) + body + bytes(4)


def vrml2(body):
    return b"#VRML V2.0 utf8\n" + body


def nested(opening, closing, depth):
    return opening * depth + closing * depth


def shape(points, index=None):
    kind = b"PointSet" if index is None else b"IndexedFaceSet"
    faces = b"" if index is None else b" coordIndex [ " + index + b" ]"
    coordinates = b" { coord Coordinate { point [ " + points + b" ] }"
    return b"Shape { geometry " + kind + coordinates + faces + b" } }"


def billion_laughs():
    rows = [b"DEF A0 Transform { children " + shape(b"0 0 0") + b" }"]
    for k in range(1, 40):
        rows.append(b"DEF A%d Transform { children [ USE A%d USE A%d ] }" % (k, k - 1, k - 1))
    return vrml2(b"\n".join(rows))


def mcap_chunk(size, packed, packing=b"zstd"):
    body = struct.pack("<QQQI", 0, 1, size, 0) + struct.pack("<I", len(packing)) + packing
    body += struct.pack("<Q", len(packed)) + packed
    return mcap.MAGIC + struct.pack("<BQ", 6, len(body)) + body


def pcd(head="", width=3, height=1, data="ascii", body=b"0 0 0\n" * 3, points=None):
    points = width * height if points is None else points
    rows = f"VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\n{head}"
    return (
        rows + f"WIDTH {width}\nHEIGHT {height}\nPOINTS {points}\nDATA {data}\n"
    ).encode() + body


BOMB = zlib.compress(bytes(64 << 20), 9)

HOSTILE = {
    # lying headers
    "ply-huge-count": ply(
        b"element face 1\nproperty list uchar int vertex_indices\nend_header\n", HUGE
    ),
    "ply-more-than-there": ply(b"end_header\n" + TRIANGLE.encode(), 4),
    "ply-binary-short": ply(b"end_header\n" + bytes(35), 3, "binary_little_endian"),
    "ply-negative-count": ply(b"element face -3\nend_header\n" + TRIANGLE.encode()),
    "ply-count-of-20-digits": ply(b"end_header\n", "99999999999999999999"),
    "ply-no-format": b"ply\nelement vertex 1\nend_header\n",
    "ply-unknown-type": ply(b"property quad w\nend_header\n"),
    "ply-no-end": ply(b"comment " + b"x" * 70000),
    "ply-4000-properties": ply(b"property float p\n" * 4000 + b"end_header\n"),
    "ply-list-in-vertex": ply(b"property list uchar int l\nend_header\n" + TRIANGLE.encode()),
    "ply-float-list-count": ply(
        b"element face 1\nproperty list float int vertex_indices\nend_header\n"
    ),
    "ply-list-longer-than-file": ply(
        b"element face 1\nproperty list int int vertex_indices\nend_header\n"
        + bytes(36)
        + struct.pack("<i", HUGE),
        3,
        "binary_little_endian",
    ),
    "ply-negative-list": ply(
        b"element face 1\nproperty list int int vertex_indices\nend_header\n"
        + bytes(36)
        + struct.pack("<i", -1),
        3,
        "binary_little_endian",
    ),
    "ply-index-out-of-range": ply(
        b"element face 1\nproperty list uchar int vertex_indices\nend_header\n"
        + TRIANGLE.encode()
        + b"3 0 1 3\n"
    ),
    "ply-negative-index": ply(
        b"element face 1\nproperty list uchar int vertex_indices\nend_header\n"
        + TRIANGLE.encode()
        + b"3 0 1 -2\n"
    ),
    "ply-words-for-numbers": ply(b"end_header\n0 0 zero\n1 1 1\n2 2 2\n"),
    "ply-all-nan": ply(b"end_header\n" + b"nan nan nan\n" * 3),
    "ply-range-grid-without-size": ply(
        b"element range_grid 1\nproperty list uchar int vertex_indices\nend_header\n"
        + TRIANGLE.encode()
        + b"0\n"
    ),
    "ply-empty-element-huge": ply(b"element nothing 2147483647\nend_header\n0 0 0\n", 3),
    "obj-index-zero": b"v 0 0 0\nv 90 0 0\nv 0 90 0\nf 0 1 2\n",
    "obj-index-beyond": b"v 0 0 0\nv 90 0 0\nv 0 90 0\nf 1 2 4\n",
    "obj-index-before-first": b"v 0 0 0\nv 90 0 0\nv 0 90 0\nf -1 -2 -4\n",
    "obj-two-coordinates": b"v 0 0 0\nv 0 1\n",
    "obj-not-a-number": b"v 0 0 0\nv 0 1 x\n",
    "obj-index-of-30-digits": b"v 0 0 0\nv 90 0 0\nv 0 90 0\nf 1 2 " + b"9" * 30,
    "off-huge": b"OFF\n2147483647 2147483647 0\n",
    "off-negative": b"OFF\n-3 1 0\n",
    "off-nan": b"OFF\nnan nan 0\n",
    "off-short-face": b"OFF\n3 1 0\n" + TRIANGLE.encode() + b"4 0 1 2\n",
    "off-index": b"OFF\n3 1 0\n" + TRIANGLE.encode() + b"3 0 1 7\n",
    "off-binary": b"OFF BINARY\n" + bytes(40),
    "stl-huge-count": (b"solid x".ljust(80) + struct.pack("<I", HUGE) + bytes(100), "a.stl"),
    "stl-no-end": b"solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\n",
    "stl-two-corners": b"solid a\nfacet\nvertex 0 0 0\nvertex 1 0 0\nendfacet\nendsolid a\n",
    "stl-empty": b"solid a\nendsolid a\n",
    "pcd-huge": pcd(width=HUGE, height=HUGE),
    "pcd-lying-points": pcd(points=7),
    "pcd-compressed-lie": pcd(
        data="binary_compressed", width=10**6, body=struct.pack("<II", 9, 12 * 10**6) + bytes(9)
    ),
    "pcd-compressed-reference-before-start": pcd(
        data="binary_compressed", body=struct.pack("<II", 2, 36) + b"\xff\xff"
    ),
    "pcd-count-huge": pcd(head="COUNT 1 1 100000000\n"),
    "pcd-no-z": pcd().replace(b"FIELDS x y z", b"FIELDS x y w"),
    "pcd-unknown-data": pcd(data="xml"),
    "vrml-not-closed": vrml2(b"Shape { geometry IndexedFaceSet { coord Coordinate { point [ 0 0 0"),
    "vrml-deep-nodes": vrml2(nested(b"Transform { children [ ", b" ] }", 100_000)),
    "vrml-deep-lists": vrml2(b"Group { children " + nested(b"[ A { ", b" } ]", 100_000)),
    "vrml-billion-laughs": billion_laughs(),
    "vrml-uses-itself": vrml2(b"DEF A Transform { children USE A }"),
    "vrml-200k-words": vrml2(b"a b " * 200_000),
    "vrml-blanks-and-commas": vrml2(b" , " * 300_000 + b'"'),
    "vrml-unclosed-text": vrml2(b'WorldInfo { title "' + b"\\" * 100_001),
    "vrml-not-triples": vrml2(shape(b"0 0 0 1")),
    "vrml-index-beyond": vrml2(shape(b"0 0 0", b"0 1 2 -1")),
    "vrml-only-inline": vrml2(b'Inline { url "http://example.org/face.wrl" }'),
    "vrml-scale-overflows": vrml2(
        b"Transform { scale 1e308 1e308 1e308 children " + shape(b"9e99 1 1") + b"}"
    ),
    "bnt-lying-count": struct.pack("<HHdH", 3, 3, -1e9, 0) + struct.pack("<I", 45) + bytes(100),
    "bnt-65535": struct.pack("<HHdH", 65535, 65535, -1e9, 0)
    + struct.pack("<I", (5 * 65535**2) % 2**32),
    "abs-huge": b"999999999 rows\n999999999 columns\npixels (flag X Y Z):\n1 1 1\n",
    "abs-zero": b"0 rows\n0 columns\npixels (flag X Y Z):\n",
    "abs-short": b"100 rows\n100 columns\npixels (flag X Y Z):\n" + b"1 " * 9000,
    "biwi-huge": (struct.pack("<iiii", HUGE, HUGE, 0, 1), "frame_00001_depth.bin"),
    "biwi-negative": (struct.pack("<iiii", -640, 480, 0, 1), "frame_00001_depth.bin"),
    "biwi-run-too-long": (struct.pack("<iiii", 64, 48, 0, HUGE), "frame_00001_depth.bin"),
    "biwi-empty-runs": (struct.pack("<ii", 64, 48) + bytes(80_000), "frame_00001_depth.bin"),
    "swissranger-no-distance": b"% Amplitude\n" + b"1 " * 25344,
    "swissranger-short": b"% Calibrated Distance\n" + b"0.4 " * 176 + b"\n",
    "swissranger-blanks": b"% Calibrated Distance\n" + (b" " * 400 + b"\n") * 2000,
    "vap-short": b" ".join([b"700"] * 640) + b"\n",
    "xyz-ragged": b"0 0 0\n1 1 1\n2 2\n",
    "csv-words": b"x,y,z\n1,2,3\n4,five,6\n",
    # images
    "png-huge": png(HUGE, HUGE),
    "png-zero": png(0, 5),
    "png-8-bit": png(4, 4, bits=8),
    "png-rgb": png(4, 4, colour=2),
    "png-interlaced": png(4, 4, interlace=1),
    "png-bomb": png(4096, 2048, BOMB),
    "png-filter-9": png(1, 1, zlib.compress(b"\x09\0\0")),
    "png-no-deflate": png(4, 4, b"not deflate at all"),
    "png-wrong-checksum": png(1, 1, zlib.compress(bytes(3)))[:-8] + bytes(8),
    "png-chunk-of-4-gb": b"\x89PNG\r\n\x1a\n\xff\xff\xff\xffIHDR",
    "tiff-huge": tiff(width=HUGE, height=HUGE),
    "tiff-offset-beyond": tiff(offset=10**9),
    "tiff-tags-beyond": b"II*\0" + struct.pack("<I", HUGE),
    "tiff-many-tags": b"II*\0" + struct.pack("<IH", 8, 65535),
    "tiff-tiny-tiles": tiff(width=4000, height=2000, tile_w=1, tile_h=1, tiles=8, tile_counts=2),
    "tiff-huge-tiles": tiff(tile_w=HUGE, tile_h=HUGE, tiles=8, tile_counts=2),
    "tiff-8-bit": tiff(bits=8),
    "tiff-jpeg": tiff(packing=7),
    "tiff-packbits-bomb": tiff(width=4000, height=2000, packing=32773, count=32),
    "tiff-zero-rows": tiff(rows=0),
    # archives
    "npz-bomb": npz(depth=npy((4096, 2048), bytes(4 * 4096 * 2048))),
    "npz-lying-shape": npz(depth=npy((40000, 40000))),
    "npz-negative-shape": npz(depth=npy((-5, 5))),
    "npz-objects": npz(depth=npy((1,), b"cos\nsystem\n", "|O")),
    "npz-code-in-header": npz(depth=npy("__import__('os').getcwd()")),
    "npz-three-dimensions": npz(depth=npy((1, 1, 1), bytes(4))),
    "npz-nothing": npz(other=npy((1,), bytes(4))),
    "npz-camera-nan": npz(
        depth=npy((1, 1), struct.pack("<f", 700)),
        camera=npy((4,), struct.pack("<4f", *[np.nan] * 4)),
    ),
    "npz-infinite-camera": npz(
        depth=npy((1, 1), struct.pack("<f", 700)),
        camera=npy((4,), struct.pack("<4f", *[np.inf] * 4)),
    ),
    "zip-nonsense": b"PK\x03\x04" + bytes(100),
    "gzip-bomb": gzip.compress(bytes(160 << 20), 9, mtime=0),
    "gzip-in-gzip": gzip.compress(gzip.compress(b"v 0 0 0\n" * 9)),
    "gzip-torn": gzip.compress(b"v 0 0 0\n" * 9)[:-9],
    "mcap-only-magic": mcap.MAGIC,
    "mcap-chunk-of-exabytes": mcap_chunk(2**62, b"x" * 10),
    "mcap-chunk-broken": mcap_chunk(1000, b"not zstandard"),
    "mcap-chunk-lies": mcap_chunk(10, b"\x28\xb5\x2f\xfd" + bytes(20)),
    "mcap-unknown-packing": mcap_chunk(10, b"x", b"rar\0\0"),
    "mcap-record-beyond": mcap.MAGIC + struct.pack("<BQ", 5, 2**63),
    # nothing at all
    "empty": b"",
    "gzip-of-nothing": gzip.compress(b""),
    "only-a-mark": b"\xef\xbb\xbf",
    "one-byte": b"\0",
    "zeros": bytes(1 << 16),
    "ones": b"\xff" * (1 << 16),
    "newlines": b"\n" * (1 << 20),
    "blanks": b" " * (1 << 20),
    "one-long-line": b"7 " * (1 << 19),
    "digits": b"9" * (1 << 20),
}


@pytest.mark.parametrize("name", HOSTILE)
def test_a_hostile_file_is_refused(name, tmp_path):
    data = HOSTILE[name]
    data, file = data if isinstance(data, tuple) else (data, name)
    path = tmp_path / file
    path.write_bytes(data)
    (tmp_path / "camera.toml").write_bytes(files.camera_toml())
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    begin = time.process_time()
    with pytest.raises(ScanError) as caught:
        io.read_scan(path)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)
    assert time.process_time() - begin < 10.0  # a hang; the aim, 200 ms, is measured by the fuzzer
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 256 * 1024


def test_there_are_at_least_sixty():
    assert len(HOSTILE) >= 60


@pytest.mark.parametrize("writer", files.FILES.values(), ids=lambda f: f.__name__)
def test_truncation_at_every_64th(writer, tmp_path):
    """A torn file is refused, or what is left of it is a whole smaller one: never half a number."""
    whole = writer()
    data = next(iter(whole.values()))
    path = files.write(whole, tmp_path)
    full = io.read_points(path).points
    for k in range(64):
        path.write_bytes(data[: len(data) * k // 64])
        points = None
        with contextlib.suppress(ScanError):
            points = io.read_points(path).points
        if points is not None:
            assert writer.__name__ in ("xyz", "csv", "obj", "recording", "recording_chunked",
                                       "swissranger", "abs_text")  # fmt: skip
            assert np.isfinite(points).all()
            assert len(points) <= len(full)


@pytest.mark.parametrize("key", ["max_bytes", "max_points", "max_pixels", "max_nesting"])
def test_limits_are_parameters(key, tmp_path):
    by_limit = {"max_bytes": files.obj, "max_points": files.obj, "max_pixels": files.png,
                "max_nesting": files.vrml2}  # fmt: skip
    path = files.write(by_limit[key](), tmp_path)
    with pytest.raises(ScanError) as caught:
        io.read_scan(path, limits=io.Limits(**{key: 2}))
    assert caught.value.fault is ScanFault.TOO_LARGE


def test_the_expansion_ratio_is_a_parameter(tmp_path):
    path = tmp_path / "zeros.gz"
    path.write_bytes(gzip.compress(b"0 0 0\n" * (4 << 20), mtime=0))  # 24 MiB of points
    with pytest.raises(ScanError, match="expand"):
        io.read_points(path, limits=io.Limits(max_ratio=2))


def test_triangles_that_cover_the_image_again_and_again_are_refused(tmp_path):
    rows = ["v 0 0 0", "v 2000 0 0", "v 0 2000 0", *["f 1 2 3"] * 2000]
    path = tmp_path / "overdraw.obj"
    path.write_text("\n".join(rows))
    with pytest.raises(ScanError, match="cover"):
        io.read_scan(path)


@pytest.mark.parametrize("text", [
    "{", "[]", '{"intrinsics": [1, 2]}', '{"K": [[0,0,0],[0,0,0],[0,0,1]]}', "[" * 100_000,
    '{"fx": "a", "fy": 1, "cx": 1, "cy": 1}', '{"K": [[1e999,0,1],[0,1,1],[0,0,1]]}',
])  # fmt: skip
def test_a_bad_truedepth_json_is_refused(text, tmp_path):
    whole = files.truedepth()
    whole["f.json"] = text.encode()
    with pytest.raises(ScanError, match=r"f\.json"):
        io.read_scan(files.write(whole, tmp_path))


def test_bad_landmarks_and_poses_are_refused(tmp_path):
    path = tmp_path / "a.lm3"
    for text in ("", "no numbers\n", "1 2 3\n", "Nose tip\n1 2 3 4\n"):
        path.write_text(text)
        with pytest.raises(ScanError):
            io.read_landmarks(path)
    pose = tmp_path / "a_pose.txt"
    for text in ("1 2 3", "2 0 0 0 1 0 0 0 1 0 0 0", "-1 0 0 0 1 0 0 0 1 0 0 0", "nan " * 12):
        pose.write_text(text)
        with pytest.raises(ScanError):
            io.read_pose(pose)
    pose.write_bytes(struct.pack("<6f", *[np.nan] * 6))
    with pytest.raises(ScanError):
        io.read_pose(pose)
    cal = files.biwi() | {"depth.cal": b"0 0 0 0 0 0 0 0 0"}
    with pytest.raises(ScanError, match=r"depth\.cal"):
        io.read_scan(files.write(cal, tmp_path))


def test_writers_refuse_what_a_format_cannot_hold(tmp_path):
    parallel = RangeImage([[5.0, -5.0]], Orthographic(1.0, 0, 0, 2, 1))
    for name, words in (("a.png", "depth"), ("a.mcap", "pinhole"), ("a.gif", "ending")):
        with pytest.raises(ParameterError, match=words):
            io.write_scan(tmp_path / name, parallel)
    with pytest.raises(ParameterError, match="too far"):
        io.write_scan(tmp_path / "a.png", RangeImage([[3e9]], Orthographic(1.0, 0, 0, 1, 1)))
    with pytest.raises(ParameterError, match="ply"):
        io.write_points(tmp_path / "a.obj", PointSet([[0, 0, 0]]))
    with pytest.raises(ParameterError, match="mcap"):
        io.write_frames(tmp_path / "a.bag", [])
    with pytest.raises(ParameterError, match="rate_hz"):
        io.write_frames(tmp_path / "a.mcap", [], rate_hz=0)
    assert not list(tmp_path.iterdir())


def test_a_unit_must_be_known():
    with pytest.raises(UnitError, match="parsec"):
        io.unit_mm("parsec")
