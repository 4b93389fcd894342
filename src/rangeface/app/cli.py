"""The command line: thin commands over the package; heavy imports inside them."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

from rangeface.errors import ParameterError, RangeFaceError

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
key_app = typer.Typer(
    help="Keys of the service: who may do what, until when.", no_args_is_help=True
)
app.add_typer(key_app, name="key")
gallery_app = typer.Typer(
    help="A gallery as a whole: rebuild, backup, export, import.", no_args_is_help=True
)
app.add_typer(gallery_app, name="gallery")

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
Detail = Annotated[
    bool,
    typer.Option("--detail", help="Each head left out, weights held out over people, every error."),
]
Against = Annotated[
    str | None,
    typer.Option("--against", help="Preset to train here and to compare with, probe by probe."),
]
JsonFile = Annotated[Path | None, typer.Option("--json", help="Write results here.")]
ReportFolder = Annotated[
    Path | None, typer.Option("--report", help="Folder for an HTML report, tables and scores.")
]
Pipeline = Annotated[str, typer.Option("--pipeline", help="Name of a preset, or a file FILE.toml.")]
Rated = Annotated[
    str | None,
    typer.Option("--pipeline", help="Preset or FILE.toml to train here. Default: score a model."),
]
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
Address = Annotated[
    str,
    typer.Argument(
        metavar="SOURCE",
        help="synthetic:SENSOR, mcap:FILE, dir:FOLDER, realsense:NUMBER or orbbec:NUMBER.",
    ),
]
Seconds = Annotated[
    float | None, typer.Option("--seconds", help="Stop after so long by the camera's clock.")
]
PagePort = Annotated[int, typer.Option("--port", help="0: any free one.", min=0, max=65535)]
Recordings = Annotated[Path, typer.Option("--recordings", help="Folder of recordings.")]
KeepFrontal = Annotated[
    bool,
    typer.Option("--keep-frontal", help="Keep the frontal image, sealed, for `gallery rebuild`."),
]
Keys = Annotated[Path, typer.Option("--keys", help="File of the keys; made where it is missing.")]
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


@app.command()
def experiment(
    names: Annotated[
        list[str], typer.Argument(metavar="NAME…", help="table1 … table8, …, or all.")
    ],
    data: Annotated[
        str,
        typer.Option("--data", help="synthetic, ict:PATH, gavab:PATH or rap3df:PATH."),
    ] = "synthetic",
    persons: Annotated[
        int | None, typer.Option("--persons", help="How many people. Default: the paper's.", min=2)
    ] = None,
    seed: Annotated[int, typer.Option("--seed", help="Other seeds are other people.", min=0)] = 0,
    executor: Annotated[
        str, typer.Option("--executor", help="serial, processes or dask:ADDRESS.")
    ] = "processes",
    out: Annotated[Path, typer.Option("--out", help="Folder for reports and results.")] = Path(
        "rangeface-experiments"
    ),
) -> None:
    """Repeat an experiment of the source paper, or one of ours; a run that stopped goes on."""
    from rangeface.app import experiment as laboratory

    laboratory.run(names, data=data, persons=persons, seed=seed, executor=executor, out=out)


@evaluate_app.command("rap3df")
def evaluate_rap3df(
    path: Annotated[Path, typer.Argument(help="Folder rap3df_data, or the one that holds it.")],
    pipeline: Rated = None,
    model: Model = None,
    grid: Grid = False,
    detail: Detail = False,
    against: Against = None,
    exclude: Exclude = None,
    reference: ReferenceCsv = None,
    fmr: RatedFmr = None,
    json_file: JsonFile = None,
    report: ReportFolder = None,
) -> None:
    """Evaluate on RAP3DF (2017): one gallery capture a person, all tests as probes."""
    from rangeface import datasets
    from rangeface.app import evaluate

    evaluate.run("rap3df", datasets.rap3df(path), pipeline, grid=grid, model=model,
                 detail=detail, against=against,
                 exclude=exclude or [], reference=reference, json_file=json_file,
                 fmr=fmr, report=report)  # fmt: skip


@evaluate_app.command("folder")
def evaluate_folder(
    path: Annotated[Path, typer.Argument(help="Folder with an index.csv.")],
    pipeline: Rated = None,
    model: Model = None,
    grid: Grid = False,
    detail: Detail = False,
    against: Against = None,
    exclude: Exclude = None,
    reference: ReferenceCsv = None,
    fmr: RatedFmr = None,
    json_file: JsonFile = None,
    report: ReportFolder = None,
) -> None:
    """Evaluate on your own folder: index.csv with path,subject,role,view,session."""
    from rangeface import datasets
    from rangeface.app import evaluate

    evaluate.run("folder", datasets.folder(path), pipeline, grid=grid, model=model,
                 detail=detail, against=against,
                 exclude=exclude or [], reference=reference, json_file=json_file,
                 fmr=fmr, report=report)  # fmt: skip


@evaluate_app.command("database")
def evaluate_database(
    name: Annotated[str, typer.Argument(help="One of those that `rangeface datasets` lists.")],
    path: Annotated[Path, typer.Argument(help="Your folder of it.")],
    protocol: Annotated[
        str | None, typer.Option("--protocol", help="Default: the first that it has.")
    ] = None,
    pipeline: Rated = None,
    model: Model = None,
    grid: Grid = False,
    detail: Detail = False,
    against: Against = None,
    exclude: Exclude = None,
    fmr: RatedFmr = None,
    json_file: JsonFile = None,
    report: ReportFolder = None,
) -> None:
    """Evaluate on any database that rangeface knows, by one of its published protocols."""
    from rangeface.app import databases, evaluate

    scans = databases.scans(name, path, protocol)
    evaluate.run(name, scans, pipeline, grid=grid, model=model,
                 detail=detail, against=against, exclude=exclude or [],
                 reference=None, json_file=json_file, fmr=fmr, report=report)  # fmt: skip


@evaluate_app.command("synthetic")
def evaluate_synthetic(
    people: Annotated[int, typer.Option("--people", min=2)] = 40,
    sensor: Annotated[str, typer.Option("--sensor", help="Preset of a sensor.")] = "sr3000",
    distance_mm: Annotated[float, typer.Option("--distance-mm", help="Face to camera.")] = 400.0,
    frames: Annotated[int, typer.Option("--frames", help="Frames combined a probe.", min=1)] = 1,
    seed: Annotated[int, typer.Option("--seed")] = 0,
    pipeline: Rated = None,
    model: Model = None,
    grid: Grid = False,
    detail: Detail = False,
    against: Against = None,
    fmr: RatedFmr = None,
    json_file: JsonFile = None,
    report: ReportFolder = None,
) -> None:
    """Evaluate on simulated people before a simulated camera; no data needed."""
    from rangeface.app import evaluate
    from rangeface.evaluation import synthetic

    scans = synthetic.scans(people=people, sensor=sensor, distance_mm=distance_mm,
                            frames=frames, seed=seed)  # fmt: skip
    evaluate.run("synthetic", scans, pipeline, grid=grid, model=model,
                 detail=detail, against=against, exclude=[], reference=None,
                 json_file=json_file, fmr=fmr, report=report)  # fmt: skip


@evaluate_app.command("scores")
def evaluate_scores(
    file: Annotated[Path, typer.Argument(help="CSV with columns probe,reference,mated,score.")],
    report: ReportFolder = None,
) -> None:
    """Judge anyone's scores: rates with intervals, and a report."""
    from rangeface.app import evaluation_report

    evaluation_report.judge(file, report)


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
    subject: str,
    files: Scans,
    gallery: GalleryFile,
    model: Model = None,
    camera: Camera = None,
    keep_frontal: KeepFrontal = False,
) -> None:
    """Enrol a person from one scan, or from several frames."""
    from rangeface.app import people

    people.enroll(subject, files, gallery, model, camera, keep_frontal=keep_frontal)


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


@app.command()
def explain(
    files: Scans,
    gallery: GalleryFile,
    subject: Annotated[
        str | None, typer.Option("--subject", help="Default: whoever scores best.")
    ] = None,
    fmr: Fmr = 0.001,
    model: Model = None,
    camera: Camera = None,
    out: Annotated[Path | None, typer.Option("--out", help="Picture to write.")] = None,
) -> None:
    """Show which parts of a face speak for a person; exit status 1 if not accepted."""
    from rangeface.app import explain as explanation

    explanation.run(files, gallery, subject, fmr=fmr, model=model, camera=camera,
                    out=out or Path(f"{files[0].stem}-explained.png"))  # fmt: skip


@app.command()
def watch(
    source: Address,
    gallery: Annotated[
        str | None, typer.Option("--gallery", help="Gallery file. Default: nobody is enrolled.")
    ] = None,
    model: Model = None,
    fmr: Fmr = 0.001,
    speed: Annotated[float, typer.Option("--speed", help="Of a recording; 1 is its own.")] = 1.0,
    seconds: Seconds = None,
    json_lines: Annotated[bool, typer.Option("--json", help="A line of JSON a frame.")] = False,
    visits: Annotated[
        Path | None, typer.Option("--visits", help="Write who came and went: .csv or .json.")
    ] = None,
) -> None:
    """Say who stands before a camera, without a page: decisions, counts, times."""
    from rangeface.app import watch as watching

    watching.watch(source, gallery, model, fmr=fmr, speed=speed, seconds=seconds,
                   as_json=json_lines, visits=visits)  # fmt: skip


@app.command()
def record(
    source: Address,
    target: Annotated[Path, typer.Argument(help="Recording to write: FILE.mcap.")],
    seconds: Seconds = None,
) -> None:
    """Record a camera to an MCAP file, until it ends, for some seconds, or until Ctrl-C."""
    from rangeface.app import watch as watching

    watching.record(source, target, seconds=seconds)


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


@gallery_app.command("rebuild")
def rebuild_gallery(gallery: GalleryFile, model: Model = None) -> None:
    """Make all templates anew for another model, from the frontal images that were kept."""
    from rangeface.app import galleries

    galleries.rebuild(gallery, model)


@gallery_app.command("backup")
def backup_gallery(
    target: Annotated[Path, typer.Argument(help="File to write.")],
    gallery: GalleryFile,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace what is there.")] = False,
) -> None:
    """Copy a gallery while others use it; restore by copying the other way round."""
    from rangeface.app import galleries

    galleries.backup(gallery, target, overwrite=overwrite)


@gallery_app.command("export")
def export_people(
    target: Annotated[Path, typer.Argument(help="File to write; it is not encrypted.")],
    gallery: GalleryFile,
) -> None:
    """Write everybody's templates and consents to a portable file."""
    from rangeface.app import galleries

    galleries.export(gallery, target)


@gallery_app.command("import")
def import_people(
    source: Annotated[Path, typer.Argument(help="File that `export` wrote.")], gallery: GalleryFile
) -> None:
    """Enrol everybody of a portable file."""
    from rangeface.app import galleries

    galleries.take_in(gallery, source)


@gallery_app.command("audit")
def audit_gallery(gallery: GalleryFile) -> None:
    """Print what was done to whom, by number; an altered log is noticed."""
    from rangeface.app import galleries

    galleries.audit(gallery)


@key_app.command("add")
def add_key(
    name: Annotated[str, typer.Argument(help="Who gets it.")],
    scopes: Annotated[
        list[str], typer.Option("--scope", help="identify, verify, enroll, delete, …; repeatable.")
    ],
    keys: Keys = Path("rangeface.keys"),
    days: Annotated[float | None, typer.Option("--days", help="Until it expires.", min=0)] = None,
) -> None:
    """Make a key and print it: the only time that it is shown."""
    from rangeface.app import service

    service.add_key(name, scopes, keys, days)


@key_app.command("list")
def list_keys(keys: Keys = Path("rangeface.keys")) -> None:
    """List the keys: id, scopes, expiry and name."""
    from rangeface.app import service

    service.show_keys(keys)


@key_app.command("revoke")
def revoke_key(
    identity: Annotated[str, typer.Argument(help="As `rangeface key list` shows it.")],
    keys: Keys = Path("rangeface.keys"),
) -> None:
    """Revoke a key; a running service refuses it at once."""
    from rangeface.app import service

    service.revoke_key(identity, keys)


@app.command()
def live(
    source: Address,
    gallery: GalleryFile = "memory://",
    model: Model = None,
    fmr: Fmr = 0.001,
    port: PagePort = 0,
    recordings: Recordings = Path(),
) -> None:
    """Show who stands before a camera, in the browser (pip install 'rangeface[app]')."""
    from rangeface.app import live as page

    page.show(source, gallery, model, fmr=fmr, port=port, recordings=recordings)


@app.command()
def serve(
    gallery: Annotated[
        str | None, typer.Option("--gallery", help="Gallery file, or sqlite:///FILE.")
    ] = None,
    model: Model = None,
    fmr: Fmr = 0.001,
    camera: Camera = None,
    unit: Unit = None,
    host: Annotated[str, typer.Option("--host", help="Address to listen on.")] = "127.0.0.1",
    port: PagePort = 8787,
    keys: Keys = Path("rangeface.keys"),
    tls_certificate: Annotated[
        Path | None, typer.Option("--tls-certificate", help="PEM; needed beyond 127.0.0.1.")
    ] = None,
    tls_key: Annotated[Path | None, typer.Option("--tls-key", help="PEM.")] = None,
    keep_frontal: KeepFrontal = False,
    workers: Annotated[int, typer.Option("--workers", help="Scan readers.", min=1)] = 2,
    demo: Annotated[
        bool,
        typer.Option("--demo", help="Show the live page with a synthetic camera; nothing needed."),
    ] = False,
) -> None:
    """Serve enrol, verify, identify, list and delete over HTTP (pip install 'rangeface[app]')."""
    if demo:
        from rangeface.app import live as page

        page.demo(port=port, recordings=Path())
        return
    if gallery is None:
        raise ParameterError("serve: --gallery FILE is needed (or --demo)")
    from rangeface.app import service

    service.serve(gallery, model, fmr=fmr, camera=camera, unit=unit, host=host, port=port,
                  keys=keys, tls_certificate=tls_certificate, tls_key=tls_key,
                  keep_frontal=keep_frontal, workers=workers)  # fmt: skip


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
