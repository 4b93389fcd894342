"""The compiled kernels of reading agree with plain NumPy and plain Python."""

import numpy as np
import pytest

from rangeface.numerics import rows
from rangeface.numerics.lines import count_rows, first_line, read_polygons, read_table
from rangeface.numerics.pointset import compact, covered, to_frame


def as_text(text):
    return np.frombuffer(text.encode(), np.uint8)


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_to_frame_is_a_product_with_bounds(seed, dtype):
    rng = np.random.default_rng(seed)
    points = rng.normal(0, 300, (200, 3)).astype(dtype)
    points[rng.random(points.shape) < 0.05] = rng.choice([np.nan, np.inf, -np.inf, 1e30])
    matrix = np.linalg.qr(rng.normal(size=(3, 3)))[0] * rng.uniform(0.1, 10)
    with np.errstate(all="ignore"):
        expected = points.astype(float) @ matrix.T
        expected[~(np.abs(expected) <= 1e6).all(axis=1)] = np.nan
    assert np.allclose(to_frame(points, matrix, 1e6), expected, rtol=1e-5, equal_nan=True)


@pytest.mark.parametrize("seed", range(5))
def test_compact_is_masking_and_renumbering(seed):
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(60, 3)).astype(np.float32)
    valid = rng.random(60) < 0.8
    points[~valid] = np.nan
    triangles = rng.integers(0, 60, (90, 3))
    kept, faces, wrong = compact(points, triangles)
    assert wrong == -1
    assert np.array_equal(kept, points[valid])
    number = np.cumsum(valid) - 1
    assert np.array_equal(faces, number[triangles[valid[triangles].all(axis=1)]])


@pytest.mark.parametrize("bad", [-1, 60, 2**40])
def test_compact_names_an_index_that_is_no_point(bad):
    points = np.zeros((60, 3), np.float32)
    assert compact(points, np.array([[0, 1, bad]]))[2] >= 60


def test_covered_sums_clipped_boxes():
    rng = np.random.default_rng(1)
    pixels = rng.uniform(-30, 90, (50, 2))
    triangles = rng.integers(0, 50, (70, 3)).astype(np.int32)
    boxes = np.clip(pixels[triangles], 0, [63, 47])
    sides = np.ptp(boxes, axis=1) + 1
    low, high = pixels[triangles].min(1), pixels[triangles].max(1)
    sides[(high <= 0) | (low >= [63, 47])] = 1
    assert covered(pixels, triangles, 64, 48) == pytest.approx(sides.prod(axis=1).sum())


@pytest.mark.parametrize("order", "<>")
@pytest.mark.parametrize("count_kind", ["u1", "i2", "u4"])
@pytest.mark.parametrize("item_kind", ["i1", "u2", "i4"])
def test_binary_rows_are_walked_as_they_were_written(order, count_kind, item_kind):
    kinds = ["i1", "u1", "i2", "u2", "i4", "u4", "f4", "f8"]
    rng = np.random.default_rng(4)
    lists = [rng.integers(0, 100, n) for n in rng.integers(0, 7, 20)]
    data = b"".join(
        np.float32(1).astype(order + "f4").tobytes()
        + np.array([len(one)], order + count_kind).tobytes()
        + one.astype(order + item_kind).tobytes()
        for one in lists
    )
    layout = np.array([[-1, 6], [kinds.index(count_kind), kinds.index(item_kind)]])
    counts, items = np.zeros(20, np.int64), np.zeros(200, np.int64)
    walked = np.frombuffer(data, np.uint8)
    done, stop, total = rows.walk_binary(
        walked, 0, 20, layout, 1, order == ">", rows.SIZES, counts, items
    )
    assert (done, stop) == (20, len(data))
    assert counts.tolist() == [len(one) for one in lists]
    assert items[:total].tolist() == np.concatenate(lists).tolist()
    for cut in range(len(data)):
        none = np.empty(0, np.int64)
        whole, end, _ = rows.walk_binary(
            walked[:cut], 0, 20, layout, 1, order == ">", rows.SIZES, none, none
        )
        assert whole < 20
        assert end <= cut


def test_strips_turn_every_other_triangle():
    strip = np.array([0, 1, 2, 3, -1, 4, 5, -1, 6, 7, 8])
    assert rows.strip_triangles(strip).tolist() == [[0, 1, 2], [2, 1, 3], [6, 7, 8]]


def test_tables_are_lines():
    text = as_text("# title\n1, 2;3\t4 # end\r\n\r\n  5 6 7\n8 9\n")
    table, stop = read_table(text, 0, 5, 3)
    assert table.tolist() == [[1, 2, 3], [5, 6, 7]]
    assert bytes(text[stop:]) == b"8 9\n"
    assert count_rows(text, 0) == 3
    first, after = first_line(text, 0, 2)
    assert first.tolist() == [1, 2]
    assert bytes(text[after:]).startswith(b"  5")


def test_polygons_are_lines_with_a_count():
    text = as_text("3 0 1 2 255 0 0\n\n4 5 6 7 8\n2 1\n")
    sizes, indices, stop = read_polygons(text, 0, 3)
    assert sizes.tolist() == [3, 4]
    assert indices.tolist() == [0, 1, 2, 5, 6, 7, 8]
    assert bytes(text[stop:]) == b"2 1\n"
