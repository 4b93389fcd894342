"""Reading of scan files: ours, trimesh and Open3D where they read the format."""

import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from rangeface import io

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
import scan_files


def stages() -> Iterator[tuple[str, str, dict]]:
    """Yield the stage, its size and the arms, each a callable without arguments."""
    folder = Path(tempfile.mkdtemp(prefix="rangeface-bench-"))
    gavab = scan_files.face(140, 140, 1.4)  # 14.6 k valid points, as GavabDB's 12 to 16 k
    large = scan_files.face(360, 360, 0.5)  # 97 k valid points
    for stage, writer, grid, meshes in (
        ("read VRML 1.0", scan_files.gavab, gavab, False),
        ("read VRML 2.0", scan_files.vrml2, gavab, False),
        ("read Bosphorus .bnt", scan_files.bnt, scan_files.face(220, 180, 1.0), False),
        ("read FRGC .abs", scan_files.abs_text, scan_files.face(480, 640, 0.4), False),
        ("read PLY mixed polygons", scan_files.ply_binary, large, False),  # trimesh refuses them
        ("read PLY ascii", scan_files.ply_ascii, gavab, True),
        ("read OBJ", scan_files.obj, gavab, True),
        ("read OFF", scan_files.off, gavab, True),
        ("read STL binary", scan_files.stl_binary, gavab, True),
    ):
        path = scan_files.write(writer(grid), folder)
        points = int(np.isfinite(grid[..., 2]).sum())
        arms = {"ours": lambda p=path: io.read_points(p)}
        yield stage, f"{points} points", {**arms, **(_peers(path) if meshes else {})}
    uniform = folder / "triangles.ply"
    io.write_points(uniform, io.read_points(folder / "b.ply"))
    arms = {"ours": lambda: io.read_points(uniform)}
    yield "read PLY binary", "97 k points", {**arms, **_peers(uniform)}
    depth = scan_files.write(scan_files.png(), folder)
    yield "read PNG and camera", "26 × 30", {"ours": lambda: io.read_scan(depth)}


def _peers(path: Path) -> dict:
    arms = {}
    try:
        import trimesh

        arms["trimesh"] = lambda: trimesh.load(path, process=False)
    except ImportError:
        print("trimesh is not installed: left out")
    try:
        import open3d

        arms["Open3D"] = lambda: open3d.io.read_triangle_mesh(str(path))
    except ImportError:
        print("Open3D is not installed: left out")
    return arms


if __name__ == "__main__":
    import time

    for stage, size, arms in stages():
        best = dict.fromkeys(arms, np.inf)
        for _ in range(12):
            for name, arm in arms.items():
                begin = time.perf_counter()
                arm()
                best[name] = min(best[name], time.perf_counter() - begin)
        print(f"{stage:22} {size:14}", *(f"{n} {1e3 * t:.2f} ms" for n, t in best.items()))
