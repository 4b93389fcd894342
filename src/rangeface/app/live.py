"""`rangeface live` and `rangeface serve --demo`, if the extra is installed."""

from __future__ import annotations

from pathlib import Path

from rangeface.errors import ParameterError


def show(
    source: str, gallery: str, model: Path | None, *, fmr: float, port: int, recordings: Path
) -> None:
    """Show a source on the page until told to stop."""
    try:
        from rangeface.app.viewing import run
    except ImportError as error:
        raise ParameterError(f"live: pip install 'rangeface[app]' ({error.name})") from error
    run.live(source, gallery, model, fmr=fmr, port=port, recordings=recordings)


def demo(*, port: int, recordings: Path) -> None:
    """Show the synthetic camera and people who do not exist."""
    try:
        from rangeface.app.viewing import run
    except ImportError as error:
        raise ParameterError(f"serve: pip install 'rangeface[app]' ({error.name})") from error
    run.demo(port=port, recordings=recordings)
