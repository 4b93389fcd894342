"""The command line: thin commands over the package; heavy imports inside them."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

from rangeface.errors import RangeFaceError

app = typer.Typer(
    help="Recognise faces in noisy, low-resolution range images.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)
evaluate_app = typer.Typer(
    help="Run a protocol over a data set and print rates with 95 % intervals.",
    no_args_is_help=True,
)
app.add_typer(evaluate_app, name="evaluate")

Model = Annotated[
    Path | None,
    typer.Option("--model", help="Model file of `rangeface train`. Default: the one that ships."),
]
GalleryFile = Annotated[str, typer.Option("--gallery", help="Gallery file, or sqlite:///FILE.")]
Fmr = Annotated[
    float, typer.Option("--fmr", help="Accepted false match rate of one comparison, 0 … 1.")
]
RatedFmr = Annotated[
    float | None,
    typer.Option("--fmr", help="FMR at which the FNMR is given; at least 3 / different pairs."),
]
Grid = Annotated[bool, typer.Option("--grid", help="Features × classifiers.")]
Exclude = Annotated[
    list[str] | None, typer.Option("--exclude", help="Leave out a subject; repeatable.")
]
ReferenceCsv = Annotated[
    Path | None, typer.Option("--reference", help="CSV that marks near-frontal captures.")
]
JsonFile = Annotated[Path | None, typer.Option("--json", help="Write results here.")]
Pipeline = Annotated[str, typer.Option("--pipeline", help="Name of a preset, or a file FILE.toml.")]
Camera = Annotated[
    Path | None,
    typer.Option("--camera", help="Camera TOML, where the scan file brings no camera."),
]
Unit = Annotated[
    str | None, typer.Option("--unit", help="Unit of the file's lengths, where it states none.")
]
Front = Annotated[
    str | None, typer.Option("--front", help="Axis of a mesh towards the viewer, such as +z.")
]
Up = Annotated[str | None, typer.Option("--up", help="Axis of a mesh towards the crown, as +y.")]
Scans = Annotated[
    list[Path], typer.Argument(help="Scan files of one person; several are combined frames.")
]


@app.command()
def demo(
    out: Annotated[Path, typer.Option("--out", help="Folder for the report.")] = Path(
        "rangeface-demo"
    ),
    people: Annotated[int, typer.Option("--people", help="People enrolled.", min=2)] = 24,
    strangers: Annotated[int, typer.Option("--strangers", help="People not enrolled.", min=1)] = 6,
    seed: Annotated[int, typer.Option("--seed", help="Same seed, same table.")] = 0,
) -> None:
    """Enrol simulated people, recognise them from noisy images, refuse strangers."""
    from rangeface.app import demo as demonstration

    demonstration.run(out, people=people, strangers=strangers, seed=seed)


@app.command()
def info(
    file: Path, camera: Camera = None, unit: Unit = None, front: Front = None, up: Up = None
) -> None:
    """Say what a scan file holds: format, size, range, noise, and whether there is a face."""
    from rangeface.app import scans

    scans.info(file, camera, unit=unit, front=front, up=up)


@app.command()
def convert(
    source: Annotated[Path, typer.Argument(help="Scan of any known format.")],
    target: Annotated[Path, typer.Argument(help="File to write: .npz, .png, .ply or .mcap.")],
    camera: Camera = None,
    unit: Unit = None,
    front: Front = None,
    up: Up = None,
) -> None:
    """Convert a scan; the ending of the target names the format."""
    from rangeface.app import scans

    scans.convert(source, target, camera, unit=unit, front=front, up=up)


@app.command()
def datasets(
    name: Annotated[str | None, typer.Argument(help="One of the databases.")] = None,
    path: Annotated[Path | None, typer.Argument(help="Your folder of it.")] = None,
) -> None:
    """List the databases that can be read; with a folder, say what is in it and what is missing."""
    from rangeface.app import databases

    databases.show(name, path)


@app.command()
def trace(
    file: Path,
    camera: Camera = None,
    pipeline: Pipeline = "default",
    out: Annotated[Path | None, typer.Option("--out", help="Picture to write.")] = None,
) -> None:
    """Draw every stage of a scan's way, from its depth to its features, into one picture."""
    from rangeface.app import scans

    scans.draw_trace(file, camera, pipeline, out or Path(f"{file.stem}-trace.png"))


@app.command()
def simulate(
    out: Annotated[Path, typer.Argument(help="Folder to write.")],
    people: Annotated[int, typer.Option("--people", min=1)] = 61,
    sensor: Annotated[str, typer.Option("--sensor", help="Preset of a sensor.")] = "sr3000",
    distance_mm: Annotated[float, typer.Option("--distance-mm", help="Face to camera.")] = 400.0,
    seed: Annotated[int, typer.Option("--seed", help="Same seed, same scans.")] = 0,
) -> None:
    """Write simulated people in nine views each, as a folder for `evaluate folder`."""
    from rangeface.app import simulation

    simulation.collection(out, people=people, sensor=sensor, distance_mm=distance_mm, seed=seed)


@app.command()
def figures(
    out: Annotated[Path, typer.Option("--out", help="Folder for the pictures.")] = Path(
        "rangeface-figures"
    ),
    scan: Annotated[
        Path | None, typer.Option("--scan", help="A scan for the feature figures.")
    ] = None,
    seed: Annotated[int, typer.Option("--seed", help="Number of the simulated person.")] = 11,
) -> None:
    """Redraw the source paper's figures from simulated data, or from your own scan."""
    from rangeface.app import simulation

    simulation.figures(out, scan=scan, seed=seed)


@evaluate_app.command("rap3df")
def evaluate_rap3df(
    path: Annotated[Path, typer.Argument(help="Folder rap3df_data, or the one that holds it.")],
    pipeline: Pipeline = "default",
    grid: Grid = False,
    exclude: Exclude = None,
    reference: ReferenceCsv = None,
    fmr: RatedFmr = None,
    json_file: JsonFile = None,
) -> None:
    """Evaluate on RAP3DF (2017): one gallery capture a person, all tests as probes."""
    from rangeface import datasets
    from rangeface.app import evaluate

    evaluate.run("rap3df", datasets.rap3df(path), pipeline, grid=grid,
                 exclude=exclude or [], reference=reference, json_file=json_file,
                 fmr=fmr)  # fmt: skip


@evaluate_app.command("folder")
def evaluate_folder(
    path: Annotated[Path, typer.Argument(help="Folder with an index.csv.")],
    pipeline: Pipeline = "default",
    grid: Grid = False,
    exclude: Exclude = None,
    reference: ReferenceCsv = None,
    fmr: RatedFmr = None,
    json_file: JsonFile = None,
) -> None:
    """Evaluate on your own folder: index.csv with path,subject,role,view,session."""
    from rangeface import datasets
    from rangeface.app import evaluate

    evaluate.run("folder", datasets.folder(path), pipeline, grid=grid,
                 exclude=exclude or [], reference=reference, json_file=json_file,
                 fmr=fmr)  # fmt: skip


@evaluate_app.command("database")
def evaluate_database(
    name: Annotated[str, typer.Argument(help="One of those that `rangeface datasets` lists.")],
    path: Annotated[Path, typer.Argument(help="Your folder of it.")],
    protocol: Annotated[
        str | None, typer.Option("--protocol", help="Default: the first that it has.")
    ] = None,
    pipeline: Pipeline = "default",
    grid: Grid = False,
    exclude: Exclude = None,
    fmr: RatedFmr = None,
    json_file: JsonFile = None,
) -> None:
    """Evaluate on any database that rangeface knows, by one of its published protocols."""
    from rangeface.app import databases, evaluate

    scans = databases.scans(name, path, protocol)
    evaluate.run(name, scans, pipeline, grid=grid, exclude=exclude or [], reference=None,
                 json_file=json_file, fmr=fmr)  # fmt: skip


@evaluate_app.command("synthetic")
def evaluate_synthetic(
    people: Annotated[int, typer.Option("--people", min=2)] = 40,
    sensor: Annotated[str, typer.Option("--sensor", help="Preset of a sensor.")] = "sr3000",
    distance_mm: Annotated[float, typer.Option("--distance-mm", help="Face to camera.")] = 400.0,
    frames: Annotated[int, typer.Option("--frames", help="Frames combined a probe.", min=1)] = 1,
    seed: Annotated[int, typer.Option("--seed")] = 0,
    pipeline: Pipeline = "default",
    grid: Grid = False,
    fmr: RatedFmr = None,
    json_file: JsonFile = None,
) -> None:
    """Evaluate on simulated people before a simulated camera; no data needed."""
    from rangeface.app import evaluate
    from rangeface.evaluation import synthetic

    scans = synthetic.scans(people=people, sensor=sensor, distance_mm=distance_mm,
                            frames=frames, seed=seed)  # fmt: skip
    evaluate.run("synthetic", scans, pipeline, grid=grid, exclude=[], reference=None,
                 json_file=json_file, fmr=fmr)  # fmt: skip


@app.command()
def train(
    out: Annotated[Path, typer.Argument(help="Model file to write.")],
    folder: Annotated[
        Path | None,
        typer.Option("--folder", help="Folder with an index.csv; roles train or gallery are used."),
    ] = None,
    people: Annotated[
        int, typer.Option("--people", help="Without --folder: simulated people.", min=2)
    ] = 150,
    seed: Annotated[int, typer.Option("--seed")] = 0,
    pipeline: Pipeline = "default",
) -> None:
    """Learn a model from a folder of known people, or from simulated ones."""
    from rangeface.app import models

    models.train(out, folder, people=people, seed=seed, pipeline=pipeline)


@app.command()
def calibrate(
    folder: Annotated[Path, typer.Argument(help="Folder with an index.csv, of other people.")],
    fmr: Fmr = 0.001,
    model: Model = None,
    out: Annotated[Path | None, typer.Option("--out", help="Default: the model itself.")] = None,
) -> None:
    """Learn the scores of different people, and print the threshold at a false match rate."""
    from rangeface.app import models

    models.calibrate(folder, fmr=fmr, model=model, out=out)


@app.command()
def enroll(
    subject: str, files: Scans, gallery: GalleryFile, model: Model = None, camera: Camera = None
) -> None:
    """Enrol a person from one scan, or from several frames."""
    from rangeface.app import people

    people.enroll(subject, files, gallery, model, camera)


@app.command()
def verify(
    subject: str,
    files: Scans,
    gallery: GalleryFile,
    fmr: Fmr = 0.001,
    model: Model = None,
    camera: Camera = None,
) -> None:
    """Ask whether a scan shows the person it claims to; exit status 1 if not."""
    from rangeface.app import people

    people.verify(subject, files, gallery, fmr, model, camera)


@app.command()
def identify(
    files: Scans, gallery: GalleryFile, fmr: Fmr = 0.001, model: Model = None, camera: Camera = None
) -> None:
    """Ask who a scan shows; exit status 1 for *unknown* and *cannot tell*."""
    from rangeface.app import people

    people.identify(files, gallery, fmr, model, camera)


@app.command("list")
def list_subjects(gallery: GalleryFile) -> None:
    """List who is enrolled."""
    from rangeface.app import people

    people.show(gallery)


@app.command()
def delete(subject: str, gallery: GalleryFile) -> None:
    """Delete a person from a gallery, without a trace."""
    from rangeface.app import people

    people.delete(subject, gallery)


def main() -> None:
    """Run the command line; a user's mistake is one line on standard error and exit status 2."""
    try:
        app()
    except RangeFaceError as error:
        _fail(" ".join(str(error).split()))
    except OSError as error:
        _fail(f"{error.filename or 'file system'}: {error.strerror or error}")
    except KeyboardInterrupt:
        typer.echo("interrupted", err=True)
        sys.exit(130)


def _fail(message: str) -> None:
    typer.echo(f"rangeface: {message}", err=True)
    sys.exit(2)
