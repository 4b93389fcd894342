"""Training and search, against scikit-learn and BLAS."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from rangeface.classify import MLDA, PCA, FisherfaceLDA, SurfaceMatcher
from rangeface.decide import per_subject
from rangeface.numerics.similarity import similarity

Arms = dict[str, Callable[[], object]]


def stages() -> Iterator[tuple[str, str, Arms]]:
    rng = np.random.default_rng(0)
    X, people = _faces(rng, people=100, each=15, pixels=4000)
    size = f"{X.shape[0]}×{X.shape[1]}"
    yield "fit PCA to 180", size, {"ours": lambda: PCA(180).fit(X), **_scikit_learn_pca(X)}
    yield "fit MLDA", size, {"ours": lambda: MLDA(180).fit(X, people)}
    yield (
        "fit LDA",
        size,
        {
            "ours": lambda: FisherfaceLDA().fit(X, people),
            **_scikit_learn_lda(X, people),
        },
    )
    mlda = MLDA(180).fit(X, people)
    yield "project", f"1×{X.shape[1]}", {"ours": lambda: mlda.transform(X[:1])}
    for rows in (10_000, 100_000, 1_000_000):
        yield "search", f"{rows}×180", _search(rng, rows)
    yield "surface pairs, upper face", "1×100", {"ours": _surfaces(rng)}


def _surfaces(rng: np.random.Generator) -> Callable[[], object]:
    """A bumpy bowl against a hundred others: depth and inverse variance of 80 × 50 pixels."""
    y, x = np.mgrid[-1:1:80j, -1:1:50j]
    bowls = 60 * (x**2 + y**2) + 5 * np.sin(rng.uniform(3, 9, (101, 1, 1)) * x + y)
    rows = np.stack([bowls, np.ones_like(bowls)], axis=-1).reshape(101, -1).astype(np.float32)
    matcher = SurfaceMatcher().fit(rows)
    return lambda: matcher.similarity(rows[:1], rows[1:])


def _faces(
    rng: np.random.Generator, people: int, each: int, pixels: int
) -> tuple[np.ndarray, np.ndarray]:
    """Samples of full rank with a falling spectrum, as range images have."""
    modes = rng.standard_normal((200, pixels)) / np.arange(1, 201)[:, None]
    X = np.repeat(rng.standard_normal((people, 200)), each, axis=0)
    X += 0.5 * rng.standard_normal(X.shape)
    noise = 0.05 * rng.standard_normal((people * each, pixels))
    return (X @ modes + noise).astype(np.float32), np.repeat(np.arange(people), each)


def _search(rng: np.random.Generator, rows: int) -> Arms:
    gallery = rng.standard_normal((rows, 180), dtype=np.float32)
    probe = rng.standard_normal((1, 180), dtype=np.float32)
    owners = np.arange(rows)
    squares = np.einsum("ij,ij->i", gallery, gallery)
    return {
        "ours": lambda: similarity(probe, gallery),
        "ours, best of each person": lambda: per_subject(
            similarity(probe, gallery), owners, count=rows
        ),
        # its norms are prepared, and it loses digits where rows are near each other
        "BLAS": lambda: 2 * (gallery @ probe[0]) - squares,
        "numpy": lambda: -np.linalg.norm(gallery - probe, axis=1),
    }


def _scikit_learn_pca(X: np.ndarray) -> Arms:
    from sklearn import decomposition

    full = decomposition.PCA(180, svd_solver="full")
    randomized = decomposition.PCA(180, svd_solver="randomized", random_state=0)
    return {
        "scikit-learn full": lambda: full.fit(X),
        "scikit-learn randomized": lambda: randomized.fit(X),
    }


def _scikit_learn_lda(X: np.ndarray, people: np.ndarray) -> Arms:
    from sklearn.discriminant_analysis import LinearDiscriminantAnalysis

    return {"scikit-learn svd": lambda: LinearDiscriminantAnalysis(solver="svd").fit(X, people)}
