# SPDX-License-Identifier: BSD-3-Clause
"""Starts culm, shows its progress and turns its exit codes into exceptions."""
from __future__ import annotations

import os
import shutil
import subprocess
import sys
import threading
import warnings
from pathlib import Path

# Open MPI's mpirun reports the exit code of a rank below such a line.
MPIRUN_BEGINS = "-" * 74
DONE, BAD_INPUT, POINTS_FAILED, STOPPED_EARLY = 0, 2, 3, 75


class CulmError(Exception):
    """culm ended with an error; the text is its message."""


class InputError(CulmError):
    """Input that culm refuses (exit code 2)."""


class StoppedEarly(CulmError):
    """culm stopped before the end (exit code 75). Everything computed is kept: call the function
    again with resume=True."""


class FailedPoints(UserWarning):
    """Some points or stems failed (exit code 3); the result lists them."""


def program_path() -> str:
    """$CULM_PROGRAM, or the culm that this package was installed with, or the one on the PATH."""
    installed = Path(__file__).resolve().parents[4] / "bin" / "culm"
    for found in (os.environ.get("CULM_PROGRAM"), str(installed), "culm"):
        path = shutil.which(found) if found else None
        if path:
            return path
    raise CulmError("the program culm was found neither next to this package nor on the PATH; the "
                    "environment variable CULM_PROGRAM names it")


def launcher(ranks: int) -> list[str]:
    """The words that start a program on so many ranks; none for one rank. $CULM_MPIEXEC replaces
    mpirun, for example by "srun --mpi=pmix"."""
    if ranks < 1:
        raise InputError(f"ranks = {ranks}: at least 1 is needed")
    if ranks == 1:
        return []
    words = os.environ.get("CULM_MPIEXEC", "mpirun").split()
    if shutil.which(words[0]) is None:
        raise CulmError(f"{words[0]} is not installed; ranks=1 needs no launcher")
    return [*words, "-n", str(ranks)]


def execute(arguments: list, ranks: int = 1, progress: bool = True) -> str:
    """Runs `culm arguments` to its end and returns what it printed.

    With `progress` its progress appears as in a shell, in a notebook as one line that changes.
    Raises InputError, StoppedEarly or CulmError with culm's message; warns with FailedPoints.
    Ctrl-C (or the notebook's interrupt) stops culm in an orderly way.
    """
    command = [*launcher(ranks), program_path(), *map(str, arguments)]
    # As many ranks as asked for, also on a machine with fewer cores.
    environment = {"OMPI_MCA_rmaps_base_oversubscribe": "1", **os.environ}
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                          errors="replace", env=environment) as process:
        messages: list[str] = []
        reader = threading.Thread(target=_read_messages,
                                  args=(process.stderr, messages, _display(progress)))
        reader.start()
        try:
            printed = process.stdout.read()
        except KeyboardInterrupt:
            process.terminate()
            process.wait()
            raise
        finally:
            reader.join()
    _check(process.returncode, messages)
    return printed


def _read_messages(stream, messages: list[str], show):
    for line in stream:
        messages.append(line.rstrip("\n"))
        show(messages[-1])


def _display(progress: bool):
    """A function that shows a line of culm's progress."""
    if not progress:
        return lambda line: None
    ipython = sys.modules.get("IPython")
    shell = ipython.get_ipython() if ipython else None
    if shell is None or not hasattr(shell, "kernel"):
        return lambda line: print(line, file=sys.stderr, flush=True)
    from IPython.display import TextDisplayObject, display  # a notebook has it

    class Line(TextDisplayObject):
        def __repr__(self):
            return self.data

    place = display(Line(""), display_id=True)
    return lambda line: place.update(Line(line))


def _check(exit_code: int, messages: list[str]):
    text = "\n".join(line.removeprefix("culm: ") for line in messages).strip()
    if exit_code in (BAD_INPUT, POINTS_FAILED, STOPPED_EARLY):
        text = text.split(MPIRUN_BEGINS)[0].strip()
    if exit_code == BAD_INPUT:
        raise InputError(text)
    if exit_code == STOPPED_EARLY:
        raise StoppedEarly(text)
    if exit_code == POINTS_FAILED:
        warnings.warn("some points or stems failed; the result lists them", FailedPoints,
                      stacklevel=4)
    elif exit_code != DONE:
        raise CulmError(f"culm ended with exit code {exit_code}: {text}")
