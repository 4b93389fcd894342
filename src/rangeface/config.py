"""TOML ⇄ FacePipeline: one line a slot; and the presets that ship.

A configuration is a picture of the dataclass::

    combine  = { method = "phasor_mean" }
    denoise  = { method = "normalized_convolution", sigma_px = 0.7 }
    segment  = { method = "slices", radius_mm = 140.0 }
    register = { method = "icp" }
    frontal  = { method = "resample", width = 50, height = 80 }
    assess   = { method = "quality" }
    normalise = { method = "pooled" }
    fuse     = { method = "sum" }
    decide   = { method = "open-set" }

    [[heads]]
    describe = { method = "normals" }
    classify = { method = "mlda", alpha = 6.0 }

A head may say ``learned = "shipped"``: its classifier is the one of the model that ships.
"""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Mapping
from importlib.resources import files
from pathlib import Path
from typing import Any

from rangeface import assess, classify, decide, denoise, describe, register, segment
from rangeface.errors import ParameterError
from rangeface.pipeline import FacePipeline, Head, Step, step

#: slot → its methods by name.
STAGES: dict[str, Mapping[str, Callable[..., Any]]] = {
    "combine": denoise.COMBINE,
    "denoise": denoise.METHODS,
    "segment": segment.METHODS,
    "register": register.METHODS,
    "frontal": register.FRONTAL,
    "assess": assess.METHODS,
    "normalise": decide.PER_HEAD,
    "fuse": decide.FUSE,
    "decide": decide.METHODS,
}
#: What the preset "default" is.
_DEFAULT = "fusion-3d"
_AUGMENT = ("augment_deg", "augment_noise")
_OPTIONAL = {"combine", "normalise", "fuse", "adapt_reference", *_AUGMENT}
_DEFAULTS = {
    "combine": {"method": "phasor_mean"},
    "normalise": {"method": "pooled"},
    "fuse": {"method": "sum"},
}


def presets() -> list[str]:
    """Names of the presets that ship.

    Returns
    -------
    list of str

    Examples
    --------
    >>> "full-n-mlda" in presets()
    True
    """
    folder = files("rangeface") / "presets"
    named = {f.name.removesuffix(".toml") for f in folder.iterdir() if f.name.endswith(".toml")}
    return sorted(named | {"default"})


def load_pipeline(name_or_path: str | Path) -> FacePipeline:
    """Build the pipeline of a preset, or of a TOML file.

    Parameters
    ----------
    name_or_path : str or Path
        Name of a preset, or a file that ends in ``.toml``.

    Returns
    -------
    FacePipeline
        Not fitted.

    Raises
    ------
    ParameterError
        Unknown preset, missing file, or a mistake in it; the message names the slot.
    """
    text = str(name_or_path)
    if text.endswith(".toml"):
        path = Path(text)
        if not path.is_file():
            raise ParameterError(f"{path}: no such configuration file")
        return _named(text, path.read_text(encoding="utf-8"))
    if text not in presets():
        raise ParameterError(
            f"unknown preset {text!r}; known: {', '.join(presets())}, or a file FILE.toml"
        )
    file = f"{_DEFAULT if text == 'default' else text}.toml"
    return _named(text, (files("rangeface") / "presets" / file).read_text("utf-8"))


def _named(name: str, text: str) -> FacePipeline:
    try:
        return from_toml(text)
    except ParameterError as error:
        raise ParameterError(f"{name}: {error}") from error


def from_toml(text: str) -> FacePipeline:
    """Build a pipeline from the text of a configuration.

    Parameters
    ----------
    text : str
        TOML.

    Returns
    -------
    FacePipeline
        Not fitted.

    Raises
    ------
    ParameterError
        Broken TOML, a missing or unknown slot, an unknown method or parameter.
    """
    try:
        table = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise ParameterError(f"broken TOML: {error}") from error
    unknown = sorted(set(table) - set(STAGES) - {"heads"} - _OPTIONAL)
    if unknown:
        known = ", ".join([*STAGES, "heads", "adapt_reference", *_AUGMENT])
        raise ParameterError(f"unknown slot {unknown[0]!r}; known: {known}")
    slots: dict[str, Any] = {
        slot: _step(slot, table.get(slot, _DEFAULTS.get(slot)), methods)
        for slot, methods in STAGES.items()
    }
    heads = table.get("heads")
    if not isinstance(heads, list) or not heads:
        raise ParameterError("heads: write at least one [[heads]] with describe and classify")
    extra: dict[str, Any] = {}
    if "adapt_reference" in table:
        if not isinstance(table["adapt_reference"], bool):
            raise ParameterError("adapt_reference: write true or false")
        extra["adapt_reference"] = table["adapt_reference"]
    for slot in _AUGMENT:
        if slot in table:
            extra[slot] = _numbers(slot, table[slot])
    return FacePipeline(
        **slots, heads=tuple(_head(k, head) for k, head in enumerate(heads)), **extra
    )


def _step(slot: str, entry: Any, methods: Mapping[str, Callable[..., Any]]) -> Step:
    method, params = _method(slot, entry, methods)
    return step(method, **params)


def _method(
    slot: str, entry: Any, methods: Mapping[str, Callable[..., Any]]
) -> tuple[Callable[..., Any], dict[str, Any]]:
    if not isinstance(entry, dict) or "method" not in entry:
        raise ParameterError(f'{slot}: write {slot} = {{ method = "…", … }}')
    name = entry["method"]
    if name not in methods:
        raise ParameterError(f"{slot}: unknown method {name!r}; known: {', '.join(methods)}")
    return methods[name], {k: v for k, v in entry.items() if k != "method"}


def _numbers(slot: str, values: Any) -> tuple[float, ...]:
    if not isinstance(values, list) or any(type(v) not in (int, float) for v in values):
        raise ParameterError(f"{slot}: write a list of numbers, e.g. {slot} = [1.0, 3.0]")
    return tuple(map(float, values))


def _head(number: int, entry: dict[str, Any]) -> Head:
    slot = f"heads[{number}]"
    describe_step = _step(f"{slot}.describe", entry.get("describe"), describe.METHODS)
    kind, params = _method(f"{slot}.classify", entry.get("classify"), classify.METHODS)
    learned = entry.get("learned", "here")
    if learned not in ("here", "shipped"):
        raise ParameterError(f'{slot}.learned: write "here" or "shipped", got {learned!r}')
    try:
        return Head(describe_step, kind(**params), shipped=learned == "shipped")
    except TypeError as error:
        raise ParameterError(f"{slot}.classify: {error}") from error


def to_toml(pipeline: FacePipeline) -> str:
    """Write a pipeline as a configuration; the inverse of `from_toml`, without what was learned.

    Parameters
    ----------
    pipeline : FacePipeline
        Its parameters must be plain values.

    Returns
    -------
    str
        TOML.

    Raises
    ------
    ParameterError
        A method is not in its stage's table, or a parameter has no TOML form.
    """
    lines = [
        f"{slot:<9} = {_entry(slot, getattr(pipeline, slot), methods)}"
        for slot, methods in STAGES.items()
    ]
    lines.append(f"adapt_reference = {_value(pipeline.adapt_reference)}")
    lines += [f"{slot} = {_value(getattr(pipeline, slot))}" for slot in _AUGMENT]
    for head in pipeline.heads:
        kinds = {kind: name for name, kind in classify.METHODS.items()}
        params = _pairs(kinds[type(head.classify)], head.classify.get_params().items())
        lines += [
            "",
            "[[heads]]",
            f"describe = {_entry('describe', head.describe, describe.METHODS)}",
            f"classify = {params}",
            *(['learned = "shipped"'] if head.shipped else []),
        ]
    return "\n".join(lines) + "\n"


def _entry(slot: str, bound: Step, methods: Mapping[str, Callable[..., Any]]) -> str:
    names = {method: name for name, method in methods.items()}
    if bound.method not in names:
        raise ParameterError(f"{slot}: {bound.name} is not one of its methods")
    plain = [(k, v) for k, v in bound.params if k != "reference"]  # learned, not configured
    return _pairs(names[bound.method], plain)


def _pairs(method: str, params: Any) -> str:
    pairs = [f'method = "{method}"'] + [f"{k} = {_value(v)}" for k, v in params if v is not None]
    return "{ " + ", ".join(pairs) + " }"


def _value(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, int | float | str):
        return repr(value).replace("'", '"')
    if isinstance(value, tuple | list):
        return "[" + ", ".join(_value(v) for v in value) + "]"
    raise ParameterError(f"{value!r} has no form in a configuration")
