"""Scenes: a file, the text of one, or a dictionary."""

from __future__ import annotations

import atexit
import hashlib
import os
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any, TypeAlias

from siloflow._ron import ron

#: A path, the text of a scene (it begins with a parenthesis or a comment), or a dictionary of its keys.
Scene: TypeAlias = str | os.PathLike[str] | Mapping[str, Any]


def text_of(scene: Scene) -> str | None:
    """Returns the text of a scene that is no file; ``None`` for a path."""
    if isinstance(scene, Mapping):
        # A line for each key, so that errors show theirs.
        return "(\n" + "".join(f"    {key}: {ron(value, str(key))},\n" for key, value in scene.items()) + ")\n"
    if isinstance(scene, str) and scene.lstrip().startswith(("(", "//", "/*", "#!")):
        return scene
    return None


def path_of(scene: Scene) -> Path:
    """Returns the path of a scene. Other scenes are as if in the working directory, with the name ``scene``."""
    return Path("scene.ron") if isinstance(scene, Mapping) or text_of(scene) is not None else Path(scene)


def _remove(path: Path) -> None:
    path.unlink(missing_ok=True)


def file_of(scene: Scene) -> Path:
    """Returns the path of a scene's file. Text gets one in the working directory until the interpreter ends, whose name depends on the text alone: a study that is called again finds its scene."""
    text = text_of(scene)
    if text is None:
        return path_of(scene)
    content = text.encode()
    path = Path(f".scene-{hashlib.sha256(content).hexdigest()[:12]}.ron")
    if not path.is_file() or path.read_bytes() != content:
        with tempfile.NamedTemporaryFile(dir=".", prefix=".scene-", delete=False) as new:
            new.write(content)
        os.replace(new.name, path)
        atexit.register(_remove, path.resolve())
    return path
