"""The wavelet transforms against PyWavelets and the dtcwt library, to 1e-5."""

from pathlib import Path

import numpy as np
import pytest
import pywt

from rangeface.numerics import dtcwt, dwt

SHAPES = [(64, 64), (51, 77), (40, 30)]
WAVELETS = ["haar", "db4", "sym8", "coif2", "bior4.4", "rbio2.2"]


def random_image(shape, seed=0):
    return np.random.default_rng(seed).normal(size=shape)


@pytest.mark.filterwarnings("ignore:Level value")
@pytest.mark.parametrize("wavelet", WAVELETS)
@pytest.mark.parametrize("shape", SHAPES)
def test_dwt_equals_pywavelets(wavelet, shape):
    x = random_image(shape)
    theirs = pywt.wavedec2(x, wavelet, mode="symmetric", level=3)
    ours = dwt.forward(x, wavelet=wavelet, levels=3)
    np.testing.assert_allclose(ours.lowpass.T, theirs[0], atol=1e-5)
    for number, (lh, hl, hh) in enumerate(ours.details):
        horizontal, vertical, diagonal = theirs[3 - number]
        if number % 2 == 0:  # levels 1 and 3 lie transposed
            lh, hl, hh = lh.T, hl.T, hh.T
        else:  # level 2 saw the image transposed
            lh, hl = hl, lh
        np.testing.assert_allclose(lh, vertical, atol=1e-5)
        np.testing.assert_allclose(hl, horizontal, atol=1e-5)
        np.testing.assert_allclose(hh, diagonal, atol=1e-5)
    np.testing.assert_allclose(dwt.inverse(ours), x, atol=1e-5)


def test_every_discrete_wavelet_of_pywavelets_reconstructs():
    x = random_image((33, 46))
    # the discrete Meyer wavelet is cut off: it does not reconstruct in PyWavelets either
    for wavelet in sorted({*pywt.wavelist(kind="discrete")} - {"dmey"}):
        bands = dwt.forward(x, wavelet=wavelet, levels=2)
        np.testing.assert_allclose(dwt.inverse(bands), x, atol=2e-4, err_msg=wavelet)


@pytest.fixture(scope="module")
def golden():
    with np.load(Path(__file__).with_name("dtcwt_golden.npz")) as arrays:
        return dict(arrays)


def cases(golden, dimension):
    return sorted({k.rsplit(" ", 1)[0] for k in golden if k.startswith(dimension)})


def compare(pyramid, golden, name):
    np.testing.assert_allclose(pyramid.lowpass, golden[f"{name} low"], atol=1e-5)
    for number, highpass in enumerate(pyramid.highpasses):
        np.testing.assert_allclose(highpass, golden[f"{name} {number}"], atol=1e-5)


def test_dual_tree_in_two_dimensions_equals_the_dtcwt_library(golden):
    names = cases(golden, "2d")
    assert len(names) == 9
    for name in names:
        _, rows, cols, first, further = name.split()
        shape = int(rows), int(cols)
        x = np.random.default_rng(list(shape)).normal(size=shape)
        compare(dtcwt.forward_2d(x, levels=3, first=first, further=further), golden, name)


def test_dual_tree_in_one_dimension_equals_the_dtcwt_library(golden):
    names = cases(golden, "1d")
    assert len(names) == 2
    for name in names:
        length = int(name.split()[1])
        x = np.random.default_rng([length]).normal(size=length)
        compare(dtcwt.forward_1d(x, levels=3, further="qshift_a"), golden, name)
