"""Random draws by counting: every sample is a hash of its index and of a key.

No state runs through the array, so the loops vectorise and the result does not depend on how the
work is cut up. The hash is C. Wellons's two-round 32-bit mixer (public domain), keyed twice;
normal deviates follow Box and Muller (Ann. Math. Stat. 29(2), 1958, doi:10.1214/aoms/1177706645),
as in the source paper, with float32 polynomials in place of library calls.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from rangeface.errors import ParameterError

_FAST = {"contract", "reassoc", "arcp", "nsz"}
_FEW = 64.0  # below this mean Poisson counts are inverted exactly

_U = np.uint32
_LN2, _HALF, _ONE, _TWO = (
    np.float32(0.693147180559945),
    np.float32(0.5),
    np.float32(1),
    np.float32(2),
)
_PI, _HALF_PI = np.float32(np.pi), np.float32(0.5 * np.pi)


def angle_noise(
    amplitude: ArrayLike, *, rng: np.random.Generator
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    r"""Error of the angle, and length, of a normally distributed point in the plane.

    .. math:: δ = \operatorname{atan2}(n_2, A + n_1), \quad n_1, n_2 \sim N(0, 1)

    The point's mean lies at distance A from the origin; the normal law is isotropic, so δ does
    not depend on the mean's direction. σ_δ → 1/A for A ≫ 1.

    Parameters
    ----------
    amplitude : array_like
        A in units of the noise, ≥ 0; NaN gives NaN.
    rng : numpy.random.Generator
        Gives the key.

    Returns
    -------
    angle : float32
        δ, rad, in [−π, π], same shape.
    length : float32
        Distance of the noisy point from the origin.

    Notes
    -----
    Polynomials are good to 2e-7 rad (sine) and 2e-6 rad (arctangent), far below the noise of any
    amplitude below 10⁵.

    Examples
    --------
    >>> angle, _ = angle_noise(np.full(100_000, 50.0), rng=np.random.default_rng(0))
    >>> bool(abs(angle.std() * 50.0 - 1.0) < 0.01)
    True
    """
    A = np.ascontiguousarray(amplitude, np.float32)
    angle, length = np.empty(A.shape, np.float32), np.empty(A.shape, np.float32)
    _angle_noise(A.ravel(), *_key(rng), angle.reshape(-1), length.reshape(-1))
    return angle, length


def normal(shape: tuple[int, ...], *, rng: np.random.Generator) -> NDArray[np.float32]:
    """Standard normal deviates.

    Parameters
    ----------
    shape : tuple of int
        Shape of the result.
    rng : numpy.random.Generator
        Gives the key.

    Returns
    -------
    float32
        Independent N(0, 1), at most 5.9 in size (24-bit uniforms).
    """
    out = np.empty(shape, np.float32)
    flat, half = out.reshape(-1), out.size - out.size // 2
    a, b = _key(rng)
    _normal(a, b, flat[: out.size - half], flat[half:])
    if half > out.size - half:  # an odd one is left in the middle
        flat[half - 1] = _single(half - 1, a, b)
    return out


def poisson(mean: ArrayLike, *, rng: np.random.Generator) -> NDArray[np.float32]:
    r"""Poisson counts.

    Means below 64 are inverted exactly. Larger ones use the Cornish–Fisher expansion of the
    quantile to second order, with the variance of the rounding taken out beforehand:

    .. math:: n = \operatorname{round}\left(λ + \sqrt{λ - \tfrac{1}{12} - \tfrac{1}{18}}\, z
              + \tfrac{z^2 - 1}{6}\right)

    Parameters
    ----------
    mean : array_like
        λ ≥ 0.
    rng : numpy.random.Generator
        Gives the key.

    Returns
    -------
    float32
        Counts of the same shape, ≥ 0.

    Raises
    ------
    ParameterError
        A mean is negative or NaN.

    References
    ----------
    R. A. Fisher, E. A. Cornish, Technometrics 2(2), 1960, doi:10.1080/00401706.1960.10489895.

    Examples
    --------
    >>> counts = poisson(np.full(100_000, 900.0), rng=np.random.default_rng(0))
    >>> bool(abs(counts.mean() - 900) < 0.5), bool(abs(counts.var() - 900) < 15)
    (True, True)
    """
    expected = np.ascontiguousarray(mean, np.float32)
    if not (expected >= 0).all():
        raise ParameterError("mean: Poisson means must be ≥ 0")
    out = normal(expected.shape, rng=rng)
    _many(expected.reshape(-1), out.reshape(-1))
    if expected.size and expected.min() < _FEW:
        _few(expected.reshape(-1), *_key(rng), out.reshape(-1))
    return out


def _key(rng: np.random.Generator) -> tuple[np.uint32, np.uint32]:
    a, b = rng.integers(0, 2**32, 2, dtype=np.uint32)
    return a, b


@njit(cache=True, nogil=True, fastmath=_FAST, error_model="numpy")
def _hash(index: np.uint32, a: np.uint32, b: np.uint32) -> np.uint32:
    x = _U(_U(index * _U(0x9E3779B9)) + a)
    x = _U(x ^ (x >> _U(16)))
    x = _U(x * _U(0x7FEB352D))
    x = _U(x ^ (x >> _U(15)))
    x = _U(_U(x ^ b) * _U(0x846CA68B))
    return _U(x ^ (x >> _U(16)))


@njit(cache=True, nogil=True, fastmath=_FAST, error_model="numpy")
def _radius(bits: np.uint32) -> np.float32:
    # √(−2 ln u) for u = (m + ½) 2⁻²⁴: exponent from the bits, ln of the mantissa by atanh series
    u = np.float32((np.float32(np.int32(bits >> _U(8))) + _HALF) * np.float32(2.0**-24))
    word = np.int32(u.view(np.int32))
    exponent = np.float32(np.int32((word >> np.int32(23)) - np.int32(127)))
    mantissa = np.int32((word & np.int32(0x7FFFFF)) | np.int32(0x3F800000)).view(np.float32)
    t = (mantissa - np.float32(1.41421356)) / (mantissa + np.float32(1.41421356))
    q = t * t
    series = np.float32(2.0) + q * (
        np.float32(2 / 3) + q * (np.float32(2 / 5) + q * np.float32(2 / 7))
    )
    ln = (exponent + _HALF) * _LN2 + t * series
    return np.sqrt(_TWO * abs(ln))


@njit(cache=True, nogil=True, fastmath=_FAST, error_model="numpy")
def _turn(bits: np.uint32) -> tuple[np.float32, np.float32]:
    # cosine and sine of a uniform angle 2πv through those of πv, v in [−½, ½)
    x = np.float32(np.int32(bits)) * np.float32(np.pi * 2.0**-32)
    q = x * x
    s = x * (
        np.float32(0.9999999995)
        + q * (np.float32(-0.16666666)
        + q * (np.float32(0.0083333072)
        + q * (np.float32(-0.0001981741) + q * np.float32(2.60190e-6))))
    )  # fmt: skip
    c = _ONE + q * (
        np.float32(-0.4999999963)
        + q * (np.float32(0.0416666418)
        + q * (np.float32(-0.0013888397)
        + q * (np.float32(2.47609e-5) + q * np.float32(-2.605e-7))))
    )  # fmt: skip
    return _ONE - _TWO * s * s, _TWO * s * c


@njit(cache=True, nogil=True, fastmath=_FAST, error_model="numpy")
def _atan2(y: np.float32, x: np.float32) -> np.float32:
    # minimax polynomial of Hastings's kind on [0, 1], then the octants
    ax, ay = abs(x), abs(y) + np.float32(1e-30)
    steep = ay > ax
    t = (ax if steep else ay) / (ay if steep else ax)
    q = t * t
    r = t * (
        np.float32(0.99997726)
        + q * (np.float32(-0.33262347)
        + q * (np.float32(0.19354346)
        + q * (np.float32(-0.11643287)
        + q * (np.float32(0.05265332) + q * np.float32(-0.01172120)))))
    )  # fmt: skip
    r = _HALF_PI - r if steep else r
    r = _PI - r if x < 0 else r
    return -r if y < 0 else r


@njit(cache=True, nogil=True, fastmath=_FAST, error_model="numpy")
def _angle_noise(
    A: NDArray[np.float32],
    a: np.uint32,
    b: np.uint32,
    angle: NDArray[np.float32],
    length: NDArray[np.float32],
) -> None:
    for i in range(A.size):
        index = _U(i)
        radius = _radius(_hash(index, a, b))
        cosine, sine = _turn(_hash(index, b, a))
        x, y = A[i] + radius * cosine, radius * sine
        angle[i] = _atan2(y, x)
        length[i] = np.sqrt(x * x + y * y)


@njit(cache=True, nogil=True, fastmath=_FAST, error_model="numpy")
def _normal(
    a: np.uint32, b: np.uint32, first: NDArray[np.float32], second: NDArray[np.float32]
) -> None:
    for i in range(first.size):  # both deviates of a pair
        index = _U(i)
        radius = _radius(_hash(index, a, b))
        cosine, sine = _turn(_hash(index, b, a))
        first[i], second[i] = radius * cosine, radius * sine


@njit(cache=True, nogil=True, fastmath=_FAST, error_model="numpy")
def _single(i: int, a: np.uint32, b: np.uint32) -> np.float32:
    return _radius(_hash(_U(i), a, b)) * _turn(_hash(_U(i), b, a))[0]


@njit(cache=True, nogil=True, fastmath=_FAST, error_model="numpy")
def _many(mean: NDArray[np.float32], out: NDArray[np.float32]) -> None:
    rounding = np.float32(1 / 12 + 1 / 18)
    for i in range(mean.size):
        z, expected = out[i], mean[i]
        spread = np.sqrt(abs(expected - rounding))
        out[i] = np.floor(expected + spread * z + (z * z - _ONE) * np.float32(1 / 6) + _HALF)


@njit(cache=True, nogil=True, error_model="numpy")
def _few(mean: NDArray[np.float32], a: np.uint32, b: np.uint32, out: NDArray[np.float32]) -> None:
    for i in range(mean.size):
        if mean[i] < _FEW:
            out[i] = _invert(np.float64(mean[i]), _hash(_U(i), a, b))


@njit(cache=True, nogil=True, error_model="numpy")
def _invert(mean: float, bits: np.uint32) -> np.float32:
    left = (np.float64(bits) + 0.5) * 2.0**-32
    term = np.exp(-mean)
    count = 0
    while left > term and count < 400:
        left -= term
        count += 1
        term *= mean / count
    return np.float32(count)
