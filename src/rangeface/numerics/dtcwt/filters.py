"""Filters of the dual-tree complex wavelet transform.

The numbers are the published designs; tests/published checks what makes them such: perfect
reconstruction, vanishing moments, and the half-sample delay between the two trees.

References
----------
N. G. Kingsbury, Appl. Comput. Harmon. Anal. 10(3), 2001, doi:10.1006/acha.2000.0343 (near-sym,
q-shift). I. W. Selesnick, R. G. Baraniuk, N. G. Kingsbury, IEEE Signal Process. Mag. 22(6), 2005,
doi:10.1109/MSP.2005.1550194. A. F. Abdelnour, I. W. Selesnick, IEEE Trans. Signal Process. 53(1),
2005, doi:10.1109/TSP.2004.838959 (Farras).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rangeface.errors import ParameterError

Taps = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class FirstLevel:
    """Filters of the first level, which both trees share: biorthogonal, symmetric, odd.

    Parameters
    ----------
    h0, g0 : (n,) float64
        Analysis and synthesis low-pass, Σ = 1. The high-passes are their modulations.
    """

    h0: Taps
    g0: Taps

    @property
    def h1(self) -> Taps:
        """Analysis high-pass: the synthesis low-pass with alternating signs."""
        return _modulated(self.g0)

    @property
    def g1(self) -> Taps:
        """Synthesis high-pass: the analysis low-pass with alternating signs."""
        return _modulated(self.h0)


@dataclass(frozen=True, eq=False)
class Orthonormal:
    """An orthonormal filter pair for one tree; the other tree has its time reverse.

    Parameters
    ----------
    h0 : (n,) float64
        Low-pass of the tree "a", n even, Σ = √2, Σ h² = 1.
    """

    h0: Taps

    @property
    def h1(self) -> Taps:
        """High-pass: alternating flip of the low-pass."""
        return self.h0[::-1] * (-1.0) ** np.arange(len(self.h0))


def _modulated(taps: Taps) -> Taps:
    return taps * (-1.0) ** (np.arange(len(taps)) - len(taps) // 2)


def _symmetric(*half: float) -> Taps:
    """Odd symmetric filter from its first half up to the centre."""
    return np.array([*half, *half[-2::-1]])


def _orthonormal(taps: str) -> Orthonormal:
    return Orthonormal(np.array(taps.split(), dtype=np.float64))


NEAR_SYM = {
    # 5 and 7 taps
    "near_sym_a": FirstLevel(
        _symmetric(-1, 5, 12) / 20,
        _symmetric(-3, -15, 73, 170) / 280,
    ),
    # 13 and 19 taps
    "near_sym_b": FirstLevel(
        _symmetric(-9, 0, 114, -240, -247, 1520, 2844) / 5120,
        _symmetric(81, 0, -1539, -2160, 8208, 27360, -63816, -59280, 343786, 641600) / 1146880,
    ),
}

Q_SHIFT = {
    "qshift_06": _orthonormal(
        """
        0.03516383657149474 0 -0.08832942445107285 0.23389032060723564
        0.7602723690661257 0.5875182977235605 0 -0.11430183714424873 0 0
        """
    ),
    "qshift_a": _orthonormal(
        """
        0.051130405283831656 -0.013975370246888838 -0.10983605166597087
        0.26383956105893763 0.7666284677930372 0.5636557101270515
        0.0008736226952170968 -0.1002312195074762 -0.0016896812725281543
        -0.006181881892116438
        """
    ),
    "qshift_b": _orthonormal(
        """
        0.003253142763653182 -0.00388321199915849 0.03466034684485349
        -0.03887280126882779 -0.11720388769911527 0.27529538466888204
        0.7561456438925225 0.5688104207121227 0.011866092033797 -0.1067118046866654
        0.023825384794920298 0.01702522388155399 -0.005439475937274115
        -0.004556895628475491
        """
    ),
    "qshift_c": _orthonormal(
        """
        -0.0047616119384559135 -0.00044602278926228516 -7.144197327965012e-05
        0.034914612306842195 -0.03727389579989796 -0.11591145742744076
        0.2763686431330317 0.7563937651990367 0.567134484100133 0.01463740596447335
        -0.11255888425752203 0.02228926326692271 0.018498682724156248
        -0.0072026778782583465 -0.0002276522058977718 0.002430349945148675
        """
    ),
    "qshift_d": _orthonormal(
        """
        -0.002284127440270531 0.0012098941630734423 -0.011834794515430786
        0.0012834569993443994 0.044365221606616996 -0.05327610880304726
        -0.1133058863621428 0.2809028632221865 0.7528160380878561 0.5658080673964587
        0.024550152433666563 -0.12018854471079482 0.018156493945546453
        0.03152637712208465 -0.006628794612430063 -0.0025761743066007948
        0.0012775586538069982 0.002411869456666278
        """
    ),
}

# first level of Selesnick's transform: even, nearly symmetric, the other tree one sample later
FARRAS = _orthonormal(
    """
    0 -0.08838834764832 0.08838834764832 0.69587998903400 0.69587998903400
    0.08838834764832 -0.08838834764832 0.01122679215254 0.01122679215254 0
    """
)


def first_level(name: str) -> FirstLevel:
    """First-level filters by name: "near_sym_a" (5, 7 taps) or "near_sym_b" (13, 19).

    Raises
    ------
    ParameterError
        No filter has this name.
    """
    if name not in NEAR_SYM:
        raise ParameterError(f"first: {name!r} is none of {', '.join(NEAR_SYM)}")
    return NEAR_SYM[name]


def q_shift(name: str) -> Orthonormal:
    """Filters of the further levels by name: "qshift_06", "qshift_a" … "qshift_d".

    Raises
    ------
    ParameterError
        No filter has this name.
    """
    if name not in Q_SHIFT:
        raise ParameterError(f"further: {name!r} is none of {', '.join(Q_SHIFT)}")
    return Q_SHIFT[name]
