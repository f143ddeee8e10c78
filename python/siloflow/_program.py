"""The program siloflow in a process of its own."""

from __future__ import annotations

import subprocess
import sys
import time
from pathlib import Path

from siloflow._siloflow import SceneError


def command(*arguments: str) -> list[str]:
    """Returns the command of the program with these arguments."""
    return [sys.executable, "-m", "siloflow", "--quiet", *arguments]


def _tell(directory: Path, before: float) -> None:
    """Prints how far a run is, from the last row of its series."""
    path = directory / "series.csv"
    try:
        if path.stat().st_mtime < before:
            return
        rows = path.read_text(encoding="utf-8").splitlines()
        names, last = rows[0].split(","), rows[-1].split(",")
        row = dict(zip(names, last))
        print(f"\r{float(row['time_s']):.4g} s, {row['inside']} grains inside, {row['out']} out  ", end="", file=sys.stderr, flush=True)
    except (OSError, KeyError, IndexError, ValueError):
        # The run has not begun, or writes a row at this moment.
        return


def finish(
    arguments: list[str], told: Path | None = None, accepts_failure: bool = False
) -> subprocess.CompletedProcess[str]:
    """Runs the program to its end. ``told`` is the directory of a run whose progress is printed. Raises ``SceneError`` for wrong input."""
    before = time.time()
    with subprocess.Popen(arguments, stdout=subprocess.PIPE, stderr=subprocess.PIPE, encoding="utf-8", errors="replace") as process:
        while True:
            try:
                out, message = process.communicate(timeout=0.5 if told is not None else None)
                break
            except subprocess.TimeoutExpired:
                if told is not None:
                    _tell(told, before)
    if told is not None:
        print(file=sys.stderr)
    status = process.returncode
    if status == 0 or (status == 1 and accepts_failure):
        return subprocess.CompletedProcess(arguments, status, out, message)
    if status == 2:
        raise SceneError(message.strip())
    if status in (130, -2):
        raise KeyboardInterrupt
    raise RuntimeError(f"{' '.join(arguments[3:])} ended with the status {status}: {message.strip()}")
