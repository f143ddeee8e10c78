"""The command line: ``python -m siloflow``, and the program ``siloflow`` of the package."""

import signal
import sys
import sysconfig
from pathlib import Path

from siloflow._siloflow import command_line


def main() -> None:
    """Runs the program on the arguments of the process."""
    # The program handles signals itself: a run that is interrupted writes a checkpoint.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    # A sweep starts the program again for each run.
    program = Path(sysconfig.get_path("scripts")) / "siloflow"
    sys.exit(command_line(sys.argv, program if program.is_file() else None))


if __name__ == "__main__":
    main()
