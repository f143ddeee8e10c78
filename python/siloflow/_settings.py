"""Settings of a scene: Python values as the text of a RON file."""

from numbers import Integral

import numpy as np


def ron(value) -> str:
    """Returns a value as RON: ``True`` as ``true``, ``None`` as ``None``, a tuple as ``(...)``, a list as ``[...]``. Text is RON already."""
    if isinstance(value, (bool, np.bool_)):
        return str(value).lower()
    if isinstance(value, dict):
        return "(" + ", ".join(f"{key}: {ron(item)}" for key, item in value.items()) + ")"
    if isinstance(value, tuple):
        return "(" + ", ".join(map(ron, value)) + ")"
    if isinstance(value, list):
        return "[" + ", ".join(map(ron, value)) + "]"
    if value is None or isinstance(value, str):
        return str(value)
    if isinstance(value, Integral):
        return str(int(value))
    # NumPy numbers are floats too.
    return repr(float(value))


def settings(given: dict | None, keys: dict) -> list[tuple[str, str]]:
    """Returns (path, RON) of each setting. In keyword arguments, ``__`` stands for the dot of a path."""
    named = {key.replace("__", "."): value for key, value in keys.items()}
    return [(path, ron(value)) for path, value in {**(given or {}), **named}.items()]
