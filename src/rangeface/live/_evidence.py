"""From scores to evidence: what a score says for a person, as a log-likelihood ratio."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rangeface.recognizer import FaceRecognizer
from rangeface.types import Float32, Float64


@dataclass(frozen=True)
class Evidence:
    r"""Log-likelihood ratio of a score: two normal laws of one variance.

    .. math:: \mathrm{LLR}(s) = \frac{2 (θ - μ)}{σ^2} (s - θ)

    μ and σ² are of the calibration's non-mated scores. Mated scores need not be known: their
    mean is set so that a score at the threshold θ, which different people reach with the
    accepted false match rate, speaks neither for nor against. Where mated scores lie higher
    than that (they mostly do), the evidence is understated.

    Parameters
    ----------
    neutral : float
        θ: the score that says nothing.
    slope : float
        Evidence per unit of score above it.
    """

    neutral: float
    slope: float

    @classmethod
    def of(cls, recognizer: FaceRecognizer, fmr: float) -> Evidence:
        """Read from a recogniser's calibration; raises ParameterError if it has none."""
        neutral = recognizer.threshold(fmr)
        mean, variance = float(recognizer.nonmated.mean()), float(recognizer.nonmated.var())
        return cls(neutral, 2.0 * (neutral - mean) / variance)

    def __call__(self, scores: Float32) -> Float64:
        """Evidence of each score."""
        return self.slope * (np.asarray(scores, np.float64) - self.neutral)
