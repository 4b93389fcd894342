"""A user's own morphable face model as a second population, through the interface of our own."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from rangeface.errors import ParameterError, ScanError, ScanFault
from rangeface.simulate._anatomy import Tissue
from rangeface.simulate._head import REFLECTIVITY, Head
from rangeface.types import Float32, Float64, PointSet

_LIMIT_BYTES = 64 * 2**20  # an OBJ file of the model has about 3 MB
_CLIP = 2.8  # identity weights beyond this leave the range of the model's own people
_TO_FACE = np.array([1.0, -1.0, -1.0], np.float32)  # y up, z forward → y down, z into the head

# blend of the model's own shapes for each expression; names without side act on both
BLENDS: Mapping[str, Mapping[str, float]] = MappingProxyType(
    {
        "neutral": {},
        "smile": {"mouthSmile": 0.9, "cheekSquint": 0.4},
        "laugh": {"mouthSmile": 1.0, "cheekSquint": 0.8, "eyeSquint": 0.5, "jawOpen": 0.5},
        "frown": {"browDown": 1.0, "mouthFrown": 0.7, "noseSneer": 0.3},
        "surprise": {"browInnerUp": 0.9, "browOuterUp": 0.9, "jawOpen": 0.6, "eyeWide": 0.8},
    }
)


@dataclass(frozen=True, eq=False)
class MorphableModel:
    """A linear face model: mean, identity modes and expression shapes in the face frame.

    Parameters
    ----------
    mean : (n, 3) float32
        Mean face, mm, nose tip at the origin.
    identity : (k, n, 3) float32
        Displacement per unit of each identity weight, mm.
    expressions : mapping of str to (n, 3) float32
        Displacement of each expression shape at full strength, mm.
    triangles : (m, 3) int32
        Indices into the vertices.
    name : str
        Where it comes from.
    """

    mean: Float32
    identity: Float32
    expressions: Mapping[str, Float32]
    triangles: NDArray[np.int32]
    name: str = ""

    def head(
        self, seed: int, *, expression: str = "neutral", strength: float = 1.0, session: int = 0
    ) -> Head:
        """The head of person number `seed`; parameters as in `simulate.head`.

        Returns
        -------
        Head
            In the face frame, all of skin.

        Raises
        ------
        ParameterError
            A negative seed or session, an unknown expression, a strength out of range.
        """
        if seed < 0 or session < 0:
            raise ParameterError(f"seed, session: must be ≥ 0, got {seed}, {session}")
        if not 0.0 <= strength <= 1.5:
            raise ParameterError(f"strength: must lie in 0 … 1.5, got {strength}")
        rng = np.random.default_rng([seed, 0x1C7])
        weights = np.clip(rng.normal(size=len(self.identity)), -_CLIP, _CLIP).astype(np.float32)
        points = self.mean + np.einsum("k,k...", weights, self.identity)
        for name, weight in self._blend(expression, [seed, session, 0x6E57]).items():
            points = points + np.float32(strength * weight) * self.expressions[name]
        points = points - points[_most_forward(self.mean)]
        skin = np.full(len(points), REFLECTIVITY[Tissue.SKIN], np.float32)
        tissue = np.zeros(len(points), np.int8)
        mark: dict[str, Float64] = {"nose_tip": np.zeros(3)}
        return Head(PointSet(points, self.triangles), tissue, skin, mark, f"{self.name} {seed}")

    def _blend(self, expression: str, key: list[int]) -> dict[str, float]:
        if expression == "random":
            rng = np.random.default_rng(key)
            some = rng.permutation(sorted(self.expressions))[:6]
            return {str(name): float(rng.uniform(0.0, 0.7)) for name in some}
        if expression not in BLENDS:
            known = ", ".join([*BLENDS, "random"])
            raise ParameterError(f"expression: unknown {expression!r}; known: {known}")
        return {
            name: weight
            for stem, weight in BLENDS[expression].items()
            for name in self.expressions
            if name in (stem, f"{stem}_L", f"{stem}_R")
        }


def ict_facekit(path: str | Path) -> MorphableModel:
    """ICT-FaceKit, from a clone of its repository or from an npz of it.

    Parameters
    ----------
    path : str or Path
        The clone (holds `FaceXModel/generic_neutral_mesh.obj`, `identity000.obj` …, and one OBJ
        file an expression; centimetres, y up, z forward), that folder itself, or an npz with
        `mean`, `ident` and `expr` (0.01 mm), `tri` and `expr_names` (mm, same axes).

    Returns
    -------
    MorphableModel
        `model.head(seed, expression="laugh")` makes heads as `simulate.head` does.

    Raises
    ------
    ScanError
        A file is missing, too large or malformed, or has another number of vertices.

    References
    ----------
    R. Li et al., CVPR 2020, arXiv:2004.03458.
    """
    source = Path(path)
    if source.suffix == ".npz":
        return _from_npz(source)
    folder = source / "FaceXModel" if (source / "FaceXModel").is_dir() else source
    mean, triangles = _read_obj(folder / "generic_neutral_mesh.obj", faces=True)
    others = sorted(f for f in folder.glob("*.obj") if f.name != "generic_neutral_mesh.obj")
    shapes: dict[str, Float32] = {}
    for file in others:
        vertices, _ = _read_obj(file, faces=False)
        if vertices.shape != mean.shape:
            detail = f"{len(vertices)} vertices, the neutral mesh has {len(mean)}"
            raise ScanError(file, ScanFault.WRONG_SIZE, detail)
        shapes[file.stem] = vertices - mean
    identity = [shape for name, shape in shapes.items() if name.startswith("identity")]
    if not identity:
        raise ScanError(folder / "identity000.obj", ScanFault.MISSING)
    expressions = {name: s for name, s in shapes.items() if not name.startswith("identity")}
    return _model(mean, np.stack(identity), expressions, triangles, millimetres=10.0)


def _from_npz(path: Path) -> MorphableModel:
    if not path.is_file():
        raise ScanError(path, ScanFault.MISSING)
    try:
        with np.load(path, allow_pickle=False) as data:
            mean = np.asarray(data["mean"], np.float32)
            identity = np.float32(0.01) * data["ident"]
            shapes = np.float32(0.01) * data["expr"]
            names, triangles = data["expr_names"], np.asarray(data["tri"], np.int32)
    except (KeyError, ValueError, OSError) as error:
        raise ScanError(path, ScanFault.MALFORMED, f"not a face model: {error}") from error
    expressions = {str(name): shape for name, shape in zip(names, shapes, strict=True)}
    return _model(mean, identity, expressions, triangles, millimetres=1.0)


def _model(
    mean: Float32,
    identity: Float32,
    expressions: Mapping[str, Float32],
    triangles: NDArray[np.int32],
    *,
    millimetres: float,
) -> MorphableModel:
    turn = np.float32(millimetres) * _TO_FACE
    placed = mean * turn
    placed = placed - placed[_most_forward(placed)]
    turned = {name: shape * turn for name, shape in expressions.items()}
    return MorphableModel(placed, identity * turn, turned, triangles, "ict-facekit")


def _most_forward(mean: Float32) -> int:
    # on the mean face, and on it only, the most forward vertex is the tip of the nose
    return int(np.argmin(mean[:, 2]))


def _read_obj(path: Path, *, faces: bool) -> tuple[Float32, NDArray[np.int32]]:
    if not path.is_file():
        raise ScanError(path, ScanFault.MISSING)
    if path.stat().st_size > _LIMIT_BYTES:
        raise ScanError(path, ScanFault.TOO_LARGE, f"more than {_LIMIT_BYTES} bytes")
    vertices: list[list[float]] = []
    triangles: list[tuple[int, int, int]] = []
    try:
        for line in path.read_text("ascii", errors="replace").splitlines():
            kind, _, rest = line.partition(" ")
            if kind == "v":
                vertices.append([float(number) for number in rest.split()[:3]])
            elif kind == "f" and faces:
                corner = [int(part.split("/")[0]) - 1 for part in rest.split()]
                triangles += [(corner[0], b, c) for b, c in pairwise(corner[1:])]
        points = np.array(vertices, np.float32).reshape(-1, 3)
    except ValueError as error:
        raise ScanError(path, ScanFault.MALFORMED, str(error)) from error
    index = np.array(triangles, np.int32).reshape(-1, 3)
    if not len(points) or not np.isfinite(points).all():
        raise ScanError(path, ScanFault.MALFORMED, "no vertices, or one that is not finite")
    if faces and (not len(index) or index.min() < 0 or index.max() >= len(points)):
        raise ScanError(path, ScanFault.MALFORMED, "no faces, or one outside the vertices")
    return points, index
