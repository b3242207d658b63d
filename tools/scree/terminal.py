"""The line of progress of a run, shown by Python: in a terminal, and in a notebook, which has none."""
from __future__ import annotations

import contextlib
import dataclasses
import fcntl
import os
import pty
import re
import shutil
import struct
import subprocess
import sys
import termios
import threading
from collections.abc import Iterator

ROWS = 24
LINE = "left "  # how the line of a run begins


@dataclasses.dataclass
class Screen:
    """Where a program writes what it says, and the words of its command line that go with this."""

    file: int
    words: list[str]


@contextlib.contextmanager
def showing_progress(wanted: bool) -> Iterator[Screen]:
    """A terminal of which the newest line of progress is shown, on one line of standard output, until the program has ended; or, where
    it is not wanted, nothing."""
    if not wanted:
        yield Screen(subprocess.DEVNULL, ["--quiet"])
        return
    columns = shutil.get_terminal_size().columns
    ours, theirs = pty.openpty()
    fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", ROWS, columns, 0, 0))
    shows = threading.Thread(target=show_lines, args=(ours, columns - 1))
    shows.start()
    try:
        yield Screen(theirs, [])
    finally:
        os.close(theirs)
        shows.join()
        os.close(ours)


def show_lines(terminal: int, width: int) -> None:
    """Shows the newest line of progress that is written to a terminal, each over the one before, until its other end is closed."""
    shown = False
    while said := read_some(terminal):
        lines = [line for line in re.split("[\r\n]+", said.decode(errors="replace")) if line.startswith(LINE)]
        if lines:
            shown = True
            print("\r" + lines[-1].rstrip().ljust(width), end="", flush=True, file=sys.stdout)
    if shown:
        print("\r" + " " * width + "\r", end="", flush=True, file=sys.stdout)


def read_some(terminal: int) -> bytes:
    """What was written to a terminal; nothing where its other end is closed."""
    try:
        return os.read(terminal, 1 << 16)
    except OSError:
        return b""
