"""VRML 1.0, VRML 2.0 / 97 and Inventor ascii: points and polygons of a scene.

Read are Coordinate3 and Coordinate, IndexedFaceSet with polygons of any size, PointSet, the
grouping nodes with their transforms, DEF and USE, Switch and LOD. Everything else is passed
over; Inline, URLs and scripts are never followed. GavabDB states a display scale of 0.5 above
points that are in mm already: this one scale of VRML 1.0 is passed over too.

The unit is mm, y up, z towards the viewer, unless the caller says otherwise.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rangeface.errors import ScanFault
from rangeface.io._cloud import Cloud, check_indices
from rangeface.io._source import Source
from rangeface.io._vrml_nodes import Node, Parser
from rangeface.numerics.polygons import fan_closed
from rangeface.numerics.se3 import rotation_matrix

_MAX_VISITS = 5_000  # nodes drawn, those drawn by USE counted again

_GROUPS_1 = {"Separator", "TransformSeparator", "WWWAnchor", "Group"}
_GROUPS_2 = {"Group", "Transform", "Anchor", "Collision", "Billboard", "Shape"}
_MOVES = {"Transform", "Translation", "Rotation", "Scale", "MatrixTransform"}


def recognise(source: Source) -> bool:
    """The comment that opens VRML and Inventor files."""
    return re.match(rb"\s*#\s*(VRML\s+V[12]|Inventor\s+V2)", source.data[:64]) is not None


def parse(source: Source) -> Cloud:
    """All points of the scene in its world frame, with the triangles of its faces."""
    old = re.match(rb"\s*#\s*(VRML\s+V1|Inventor)", source.data[:64]) is not None
    nodes = Parser(source).scene()
    scene = _Scene(source, old)
    scene.draw(nodes, np.eye(4), 0)
    return scene.cloud()


class _Scene:
    """Nodes → points and triangles in the world frame."""

    def __init__(self, source: Source, old: bool) -> None:
        self.source = source
        self.old = old
        self.visits = 0
        self.count = 0
        self.corners = 0
        self.points: list[NDArray[np.float64]] = []
        self.triangles: list[NDArray[np.int64]] = []
        self.spare: list[tuple[Node, NDArray[np.float64]]] = []
        self.drawn: dict[tuple[int, bytes], int] = {}
        self.matrices: dict[int, NDArray[np.float64]] = {}

    def cloud(self) -> Cloud:
        """Everything drawn; coordinates that no shape uses count where nothing else does."""
        if not self.points:
            for coordinates, matrix in self.spare:
                self.add_points(coordinates, matrix)
        if not self.points:
            raise self.source.error(ScanFault.NO_VALID_PIXELS, "no coordinates in the scene")
        faces = np.concatenate(self.triangles) if self.triangles else None
        return Cloud(np.concatenate(self.points), faces)

    def draw(self, nodes: list[Node], matrix: NDArray[np.float64], depth: int) -> None:
        """Draw nodes in their order; in VRML 1.0 each changes the state for the next."""
        if depth > 2 * self.source.limits.max_nesting:
            raise self.source.error(ScanFault.TOO_LARGE, "nested too deeply")
        self.draw_all(nodes, _State(matrix), depth)

    def draw_all(self, nodes: list[Node], state: _State, depth: int) -> None:
        for node in nodes:
            self.visits += 1
            if self.visits > _MAX_VISITS:
                raise self.source.error(ScanFault.TOO_LARGE, f"more than {_MAX_VISITS} nodes")
            if node.kind in ("IndexedFaceSet", "PointSet"):
                self.shape(node, state)
            elif node.kind in ("Coordinate3", "Coordinate"):
                state.coordinates = node
                self.spare.append((node, state.matrix))
            elif node.kind in ("Switch", "LOD"):
                self.draw(list(_chosen(node)), state.matrix, depth + 1)
            elif self.old and node.kind == "Group":
                self.draw_all(node.children, state, depth + 1)
            elif self.old and node.kind in _GROUPS_1:
                inner = _State(state.matrix, state.coordinates)
                self.draw_all(node.children, inner, depth + 1)
            elif self.old and node.kind in _MOVES:
                state.matrix = state.matrix @ self.matrix(node)
            elif not self.old and node.kind in _GROUPS_2:
                moved = node.kind == "Transform"
                inner_matrix = state.matrix @ self.matrix(node) if moved else state.matrix
                self.draw(node.children, inner_matrix, depth + 1)

    def matrix(self, node: Node) -> NDArray[np.float64]:
        """Matrix of a transform node, made once however often it is used."""
        if id(node) not in self.matrices:
            self.matrices[id(node)] = _matrix(node, self.old)
        return self.matrices[id(node)]

    def shape(self, node: Node, state: _State) -> None:
        """Draw an IndexedFaceSet or a PointSet with the coordinates that hold for it."""
        own = [n for n in node.children if n.kind in ("Coordinate", "Coordinate3")]
        coordinates = own[0] if own else state.coordinates
        if coordinates is None:
            return
        base, count = self.add_points(coordinates, state.matrix)
        index = node.values.get("coordIndex")
        if node.kind == "PointSet" or index is None:
            return
        self.corners += len(index)
        self.source.cap_points(self.corners // 6, "face corners / 6")
        whole = np.where(np.abs(index) < 2**31, index, 2.0**31).astype(np.int64)
        triangles = check_indices(self.source, fan_closed(whole), count)
        self.triangles.append(np.asarray(triangles + base, dtype=np.int64))

    def add_points(self, node: Node, matrix: NDArray[np.float64]) -> tuple[int, int]:
        """Number of the first point of a Coordinate node in the world frame, and how many."""
        values = node.values.get("point", np.empty(0))
        if len(values) % 3:
            raise self.source.error(
                ScanFault.MALFORMED, f"{len(values)} coordinates are no triples"
            )
        key = (id(node), matrix.tobytes())
        if key not in self.drawn:
            points = values.reshape(-1, 3)
            self.drawn[key] = self.count
            self.count += len(points)
            self.source.cap_points(self.count)
            if not np.array_equal(matrix, np.eye(4)):
                with np.errstate(over="ignore", invalid="ignore"):
                    points = points @ matrix[:3, :3].T + matrix[:3, 3]
            self.points.append(points)
        return self.drawn[key], len(values) // 3


@dataclass
class _State:
    matrix: NDArray[np.float64]
    coordinates: Node | None = None


def _chosen(node: Node) -> Iterator[Node]:
    """The child that a Switch shows, or the finest level of an LOD."""
    if node.kind == "LOD":
        yield from node.children[:1]
        return
    which = node.values.get("whichChoice", node.values.get("whichChild", np.array([-1.0])))
    number = float(which[0]) if len(which) else -1.0
    if number == -3:  # SO_SWITCH_ALL of VRML 1.0
        yield from node.children
    elif 0 <= number < len(node.children):
        yield node.children[int(number)]


def _matrix(node: Node, old: bool) -> NDArray[np.float64]:
    r"""Matrix of a transform node: T C R S_o S S_o⁻¹ C⁻¹ (ISO/IEC 14772-1, 6.52)."""
    if node.kind == "MatrixTransform":
        rows = node.value("matrix", tuple(np.eye(4).ravel()))
        return rows.reshape(4, 4).T.copy()  # VRML 1.0 multiplies row vectors
    scale = node.value("scaleFactor" if old else "scale", (1.0, 1.0, 1.0))
    if old and (scale == 0.5).all():
        scale = np.ones(3)  # GavabDB's display scale
    centre = _shift(node.value("center", (0.0, 0.0, 0.0)))
    uncentre = _shift(-node.value("center", (0.0, 0.0, 0.0)))
    turn = _turn(node.value("rotation", (0.0, 0.0, 1.0, 0.0)))
    skew = _turn(node.value("scaleOrientation", (0.0, 0.0, 1.0, 0.0)))
    with np.errstate(all="ignore"):
        stretch = np.diag([*scale, 1.0])
        shift = _shift(node.value("translation", (0.0, 0.0, 0.0)))
        return shift @ centre @ turn @ skew @ stretch @ skew.T @ uncentre


def _shift(offset: NDArray[np.float64]) -> NDArray[np.float64]:
    out = np.eye(4)
    out[:3, 3] = offset
    return out


def _turn(axis_angle: NDArray[np.float64]) -> NDArray[np.float64]:
    out = np.eye(4)
    length = float(np.linalg.norm(axis_angle[:3]))
    if np.isfinite(axis_angle).all() and 0 < length < 1e9:
        out[:3, :3] = rotation_matrix(axis_angle[:3] / length * axis_angle[3])
    return out
