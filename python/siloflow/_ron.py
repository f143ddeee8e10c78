"""Python values as the text of a RON file, for settings and for scenes written as dictionaries."""

from __future__ import annotations

from collections.abc import Mapping
from numbers import Integral
from typing import Any

import numpy as np

#: Keys whose value is a name or a title, which Python writes without quotes of RON.
_TEXTS = {"title", "file", "contacts", "name", "shape", "label"}

#: Keys whose value has names of the user's choice in place of keys.
_MAPS = {"parameters", "behaviours", "shapes", "motions", "units"}


def variant(name: str, /, *values: Any, **fields: Any) -> str:
    """Returns a choice of RON: ``variant("Fixed", 0.04)`` is ``Fixed(0.04)``, ``variant("Linear", k=1e5, damping="B(20.0)")`` is ``Linear(k: 100000.0, damping: B(20.0))``."""
    parts = [ron(value) for value in values] + [f"{key}: {ron(value, key)}" for key, value in fields.items()]
    return f"{name}({', '.join(parts)})"


def quoted(text: str) -> str:
    """Returns text in the quotes of RON."""
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'


def ron(value: Any, key: str = "") -> str:
    """Returns a value as RON: ``True`` as ``true``, ``None`` as ``None``, a tuple as ``(...)``, a list as ``[...]``. Text is RON already, except that of keys such as ``title``."""
    if isinstance(value, (bool, np.bool_)):
        return str(bool(value)).lower()
    if isinstance(value, Mapping):
        if key in _MAPS:
            return "{" + ", ".join(f"{quoted(str(name))}: {ron(item)}" for name, item in value.items()) + "}"
        return "(" + ", ".join(f"{name}: {ron(item, str(name))}" for name, item in value.items()) + ")"
    if isinstance(value, tuple):
        return "(" + ", ".join(ron(item) for item in value) + ")"
    if isinstance(value, np.ndarray):
        return ron(tuple(value.tolist()))
    if isinstance(value, list):
        return "[" + ", ".join(ron(item, key) for item in value) + "]"
    if isinstance(value, str):
        return quoted(value) if key in _TEXTS and not value.startswith(('"', "=")) else value
    if value is None:
        return "None"
    if isinstance(value, Integral):
        return str(int(value))
    # NumPy numbers are floats too.
    return repr(float(value))


def settings(given: Mapping[str, Any] | None, keys: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Returns (path, RON) of each setting. In keyword arguments, ``__`` stands for the dot of a path."""
    named = {key.replace("__", "."): value for key, value in keys.items()}
    return [(path, ron(value)) for path, value in {**(given or {}), **named}.items()]
