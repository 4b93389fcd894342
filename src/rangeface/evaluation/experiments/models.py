"""The model that ships, as cells take it: they depend on every byte of its file."""

from __future__ import annotations

import hashlib
from functools import lru_cache

from rangeface.errors import ParameterError
from rangeface.evaluation.experiments.sources import Source
from rangeface.recognizer import FaceRecognizer, default_model, default_recognizer

#: People who have met no model are numbered from here, 100,000 a seed.
FIRST_PERSON = 3_000_000


@lru_cache(maxsize=1)
def shipped() -> str:
    """Hash of the model that ships: 64 hex digits.

    Returns
    -------
    str
        Of pipeline, learned arrays, cohort and calibration: a pipeline's fingerprint knows
        nothing of the last two.
    """
    return hashlib.sha256(default_model()).hexdigest()


def recognizer(model: str) -> FaceRecognizer:
    """The model that ships, where it is the one that a cell depends on.

    Parameters
    ----------
    model : str
        Hash, as `shipped` gives it.

    Returns
    -------
    FaceRecognizer

    Raises
    ------
    ParameterError
        Another model ships here.
    """
    if model != shipped():
        raise ParameterError(
            f"model: {shipped()[:12]} ships here, asked for {model[:12]}; "
            "all workers need the same rangeface"
        )
    return default_recognizer()


def newcomers(source: Source) -> int:
    """Number of the first person of a source whom no model has met."""
    return FIRST_PERSON + 100_000 * source.seed
