"""A method with its parameters bound."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from rangeface.errors import ParameterError
from rangeface.io.reference import default_reference


@dataclass(frozen=True)
class Step:
    """A method with its parameters bound: comparable, hashable, picklable.

    Build one with `step`, which checks the parameters.

    Parameters
    ----------
    method : callable
        A public function of a stage.
    params : tuple of (str, value)
        Keyword parameters, sorted by name.
    """

    method: Callable[..., Any]
    params: tuple[tuple[str, Any], ...] = ()

    def __call__(self, *args: Any, **late: Any) -> Any:
        """Call the method; `late` are parameters known only at run time."""
        return self.method(*args, **dict(self.params), **late)

    @property
    def name(self) -> str:
        """Name of the method."""
        return self.method.__name__

    def all_params(self) -> dict[str, Any]:
        """Every keyword parameter with its value, defaults and the default reference included."""
        bound = dict(self.params)
        for name, parameter in inspect.signature(self.method).parameters.items():
            if parameter.kind is inspect.Parameter.KEYWORD_ONLY:
                bound.setdefault(name, parameter.default)
        if "reference" in bound and bound["reference"] is None:
            bound["reference"] = default_reference()
        return bound

    def with_params(self, **params: Any) -> Step:
        """The same method with some parameters changed."""
        return step(self.method, **{**dict(self.params), **params})

    def __repr__(self) -> str:
        inner = ", ".join(f"{k}={v!r}" for k, v in self.params)
        return f"{self.name}({inner})"


def step(method: Callable[..., Any], /, **params: Any) -> Step:
    """Bind keyword parameters to a method; a wrong one fails here, on its own line.

    Parameters
    ----------
    method : callable
        A public function of a stage: ``f(image, *, …)``.
    **params
        Keyword parameters of it.

    Returns
    -------
    Step

    Raises
    ------
    ParameterError
        The method has no such keyword parameter; the message lists those it has.

    Examples
    --------
    >>> from rangeface import denoise
    >>> step(denoise.median, size_px=5)
    median(size_px=5)
    """
    known = {
        name
        for name, parameter in inspect.signature(method).parameters.items()
        if parameter.kind is inspect.Parameter.KEYWORD_ONLY
    }
    for name in params:
        if name not in known:
            takes = ", ".join(sorted(known))
            raise ParameterError(f"{method.__name__}: unknown parameter {name!r}; it takes {takes}")
    return Step(method, tuple(sorted((k, _hashable(v)) for k, v in params.items())))


def _hashable(value: Any) -> Any:
    return tuple(_hashable(v) for v in value) if isinstance(value, list | tuple) else value
