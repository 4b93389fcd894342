"""Leaving heads out, weights from other people, and the causes of errors."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from rangeface.errors import DegenerateError, NoFaceError
from rangeface.evaluation.captures import Capture
from rangeface.evaluation.fusion import cross_validated, misses, only_head, right, without_head
from rangeface.evaluation.scores import Scores, rates
from rangeface.pipeline import Trace
from rangeface.types import Assessment, Faces, Orthographic, RangeImage, Scan

PEOPLE = tuple(f"p{k:02d}" for k in range(20))


def no_loader(path: Path) -> RangeImage:
    raise NoFaceError("not needed here")


def capture(subject: str, role: str, *, yaw: float = 0.0, failure: str = "") -> Capture:
    scan = Scan(Path(f"{subject}-{role}-{yaw}"), no_loader, subject=subject, role=role)
    if failure:
        return Capture(scan, None, failure)
    assessment = Assessment(yaw, 0.0, 0.0, 0.9, 0.9, 1.0, 700.0, 1.0, 0.9)
    image = RangeImage([[1.0]], Orthographic(1.0, 0, 0, 1, 1))
    return Capture(scan, Trace(image, image, Faces(), frontal=image, assessment=assessment))


def scores(seed: int = 0, signal=(4.0, 4.0, 0.0)) -> Scores:
    """Three heads; the last says nothing unless it is given a signal."""
    rng = np.random.default_rng(seed)
    heads = rng.standard_normal((3, len(PEOPLE), len(PEOPLE)))
    heads += np.array(signal)[:, None, None] * np.eye(len(PEOPLE))
    heads[:, 3] = np.nan
    probes = tuple(
        capture(p, "probe", failure="no face found" if k == 3 else "") for k, p in enumerate(PEOPLE)
    )
    fused = heads.mean(axis=0)
    return Scores(heads, heads, fused, fused, probes, PEOPLE, len(PEOPLE), "f" * 64, 1.0)


def test_leaving_out_a_head_that_says_nothing_helps_and_a_good_one_hurts():
    table = scores(signal=(2.0, 2.0, 0.0))
    rank1 = [rates(without_head(table, k)).rank1.rate for k in range(3)]
    assert rank1[2] > max(rank1[:2])
    np.testing.assert_allclose(
        without_head(table, 2).table, table.heads[:2].mean(axis=0), atol=1e-6
    )
    np.testing.assert_allclose(only_head(table, 1).table, table.heads[1], atol=1e-6)


def test_cross_validated_weights_find_the_heads_that_tell_people_apart():
    table, weights = cross_validated(
        scores(signal=(5.0, 4.0, 0.0)), rng=np.random.default_rng(0), folds=5, shrinkage=0.0
    )
    assert weights.shape == (5, 3)
    np.testing.assert_allclose(weights.sum(axis=1), 1.0)
    assert weights[:, 2].max() < 0.15
    assert np.isnan(table.table[3]).all()  # a probe that failed stays failed
    assert rates(table).rank1.rate >= 0.9


def test_no_weight_has_seen_the_probes_person():
    table = scores(signal=(3.0, 3.0, 0.0))
    spoilt = table.heads.copy()
    spoilt[:, 7, 7] = [-40.0, -40.0, 90.0]  # only person 7's own probe praises the third head
    other = Scores(spoilt, spoilt, table.table, table.raw, table.probes, PEOPLE, 20, "f" * 64, 1.0)
    folds = {"rng": np.random.default_rng(1), "folds": 20}
    _, weights = cross_validated(table, **{**folds, "rng": np.random.default_rng(1)})
    _, with_spoilt = cross_validated(other, **{**folds, "rng": np.random.default_rng(1)})
    same = np.isclose(weights, with_spoilt).all(axis=1)
    assert same.sum() == 1  # the fold that holds person 7 out


def test_one_head_cannot_be_left_out():
    with pytest.raises(DegenerateError, match="at least two heads"):
        without_head(only_head(scores(), 0), 0)


def test_every_miss_has_a_cause():
    table = scores(signal=(9.0, 9.0, 9.0))
    worse = table.table.copy()
    worse[5, 5] = -50.0
    worse[6, 6] = -50.0
    probes = list(table.probes)
    probes[5] = capture("p05", "probe", yaw=40.0)
    bad = Scores(table.heads, table.fixed, worse, worse, tuple(probes), PEOPLE, 20, "f" * 64, 1.0)
    gallery = [capture(p, "gallery", yaw=33.0 if p == "p06" else 0.0) for p in PEOPLE]
    found = {miss.probe: miss for miss in misses(bad, [*probes, *gallery])}
    assert set(found) == {3, 5, 6}
    assert found[3].causes == ("not acquired (no face found)",)
    assert not np.isfinite(found[3].rank)
    assert found[5].causes == ("yaw 40°",)
    assert found[6].causes == ("gallery: yaw 33°",)
    assert right(bad).sum() == 17
