"""Histograms of oriented gradients."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rangeface.errors import ParameterError

Float32: TypeAlias = NDArray[np.float32]
Float64: TypeAlias = NDArray[np.float64]


def hog(
    gradient_x: ArrayLike,
    gradient_y: ArrayLike,
    *,
    cell_px: int = 8,
    block_cells: int = 2,
    bins: int = 9,
) -> Float32:
    r"""Histograms of oriented gradients, block-normalised.

    Parameters
    ----------
    gradient_x, gradient_y : (…, H, W) array_like
        Derivatives to the right and down; NaN where there is none (not counted).
    cell_px : int
        Edge of a cell, px, ≥ 2; rows and columns that fill no cell are left out.
    block_cells : int
        Edge of a block, cells, ≥ 1; blocks overlap by all but one cell.
    bins : int
        Number of orientations over 180°, ≥ 2, centred on 0, 180°/bins, …

    Returns
    -------
    (…, n) float32
        Blocks in reading order, each block_cells² · bins numbers in 0 … 1.

    Raises
    ------
    ParameterError
        A parameter is out of range, or no block fits the image.

    Notes
    -----
    A gradient votes with its magnitude, shared linearly by the two nearest orientations; votes
    are not shared between cells. Blocks are scaled to unit length, clipped at 0.2 and scaled
    again (L2-Hys), with ε = 10⁻³ in the unit of the gradient.

    References
    ----------
    N. Dalal, B. Triggs, CVPR 2005, doi:10.1109/CVPR.2005.177.

    Examples
    --------
    >>> one = np.ones((4, 4))
    >>> hog(one, 0 * one, cell_px=4, block_cells=1, bins=4).round(3)
    array([1., 0., 0., 0.], dtype=float32)
    """
    gx, gy = np.asarray(gradient_x, np.float64), np.asarray(gradient_y, np.float64)
    for name, value, least in (("cell_px", cell_px, 2), ("block_cells", block_cells, 1)):
        if value < least:
            raise ParameterError(f"{name}: must be ≥ {least}, got {value}")
    if bins < 2:
        raise ParameterError(f"bins: must be ≥ 2, got {bins}")
    rows, columns = gx.shape[-2] // cell_px, gx.shape[-1] // cell_px
    if min(rows, columns) < block_cells:
        raise ParameterError(
            f"cell_px: no block of {block_cells} cells of {cell_px} px fits {gx.shape[-2:]} px"
        )
    cells = _cells(gx, gy, rows, columns, cell_px, bins)
    windows = np.lib.stride_tricks.sliding_window_view(cells, (block_cells, block_cells), (-3, -2))
    blocks = np.moveaxis(windows, -3, -1)  # (…, rows, columns, block, block, bins)
    blocks = blocks.reshape(*blocks.shape[:-3], -1)
    for limit in (0.2, 1.0):
        length = np.sqrt((blocks**2).sum(axis=-1, keepdims=True) + 1e-6)
        blocks = np.minimum(blocks / length, limit)
    return blocks.reshape(*gx.shape[:-2], -1).astype(np.float32)


def _cells(gx: Float64, gy: Float64, rows: int, columns: int, cell_px: int, bins: int) -> Float64:
    """Histograms (…, rows, columns, bins) of the cells, votes over pixels."""
    magnitude = np.nan_to_num(np.hypot(gx, gy))
    place = (np.nan_to_num(np.arctan2(gy, gx)) % np.pi) * (bins / np.pi)
    lower = np.floor(place).astype(np.int64)
    share = place - lower
    cells = np.empty((*gx.shape[:-2], rows, columns, bins))
    for b in range(bins):
        votes = np.where(lower % bins == b, 1.0 - share, 0.0)
        votes += np.where((lower + 1) % bins == b, share, 0.0)
        votes = (votes * magnitude)[..., : rows * cell_px, : columns * cell_px]
        grid = votes.reshape(*gx.shape[:-2], rows, cell_px, columns, cell_px)
        cells[..., b] = grid.sum(axis=(-3, -1)) / cell_px**2
    return cells
