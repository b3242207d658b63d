"""Command lines: what all commands have in common, and what their words may be, as types for argparse."""
import argparse
import contextlib
import functools
import math
import os
import pathlib
import re
import signal
import sys
import threading

from .errors import ScreeError

BAD_INPUT, STOPPED, READ_ENOUGH = 2, 128 + signal.SIGINT, 128 + signal.SIGPIPE  # exit statuses


def command():
    """What the command is called: tools/plot in the sources, scree-plot where it is installed."""
    path = pathlib.Path(sys.argv[0]).absolute()
    return f"tools/{path.name}" if path.parent.name == "tools" else path.name


def parser_for(page, kind=argparse.ArgumentParser):
    """A parser with a page that tells what the command does, in which the commands have the names that they are called by here."""
    if not command().startswith("tools/"):
        page = re.sub(r"tools/(\w+)", lambda match: "scree-" + match[1].replace("_", "-"), page)
    return kind(prog=command(), description=page, formatter_class=argparse.RawDescriptionHelpFormatter)


def say(problem):
    """Says on stderr what went wrong, or what is worth a warning."""
    print(f"{command()}: {problem}", file=sys.stderr)


def ends_in_a_line(main):
    """A command, by its main, whatever it ends by: what is wrong with its input, what cannot be read or written, a pipe that
    nobody reads any more, Ctrl-C."""
    @functools.wraps(main)
    def ending():
        sys.unraisablehook = interrupt_again
        try:
            status = main()
            sys.stdout.flush()
            return status
        except ScreeError as problem:
            say(problem)
            return BAD_INPUT
        except BrokenPipeError:  # who reads has read enough
            give_up_output()
            return READ_ENOUGH
        except OSError as problem:
            reason = problem.strerror or str(problem).splitlines()[0]
            say(f"{problem.filename}: {reason}" if problem.filename else f"cannot go on: {reason}")
            give_up_output()
            return BAD_INPUT
        except KeyboardInterrupt:
            say("stopped")
            return STOPPED
    return ending


def interrupt_again(passed_over):
    """Ctrl-C that met Python where it passes over exceptions, as while it frees a figure, comes again a moment later."""
    if passed_over.exc_type is KeyboardInterrupt:
        threading.Timer(0.05, os.kill, (os.getpid(), signal.SIGINT)).start()
    else:
        sys.__unraisablehook__(passed_over)


def give_up_output():
    """Drops what is left to print, so that a disk that is full, or a pipe that nobody reads, is not said again as Python ends."""
    with contextlib.suppress(OSError):
        sys.stdout.flush()
    with contextlib.suppress(OSError):  # where it is no file
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def check_ending(path, what, endings):
    """ScreeError where the name of what is to be written has another ending than those that it may have: it may be that of a deck."""
    if path.suffix.lower() not in endings:
        raise ScreeError(f"{path}: expected {what} with the ending {' or '.join(endings)}, found '{path.suffix}'")


def check_picture(path):
    """ScreeError where no picture has the ending of a name."""
    from matplotlib.backend_bases import FigureCanvasBase  # here, as matplotlib takes a second to begin
    check_ending(path, "a picture", [f".{kind}" for kind in FigureCanvasBase.get_supported_filetypes()])


def beside(path, ending):
    """What is made of a file by default: its name with another ending. ScreeError where it is a directory, whose name may be none."""
    path = pathlib.Path(path)
    if path.is_dir():
        raise ScreeError(f"{path}: expected a file, found a directory")
    return path.with_name(path.stem + ending)


def whole_from(least):
    """A whole number from the least."""
    def checked(word):
        if not word.isdecimal() or int(word) < least:
            raise argparse.ArgumentTypeError(f"expected a whole number from {least}, found '{word}'")
        return int(word)
    return checked


def above(least, below=math.inf):
    """A number above the least, and below another."""
    def checked(word):
        try:
            value = float(word)
        except ValueError:
            value = math.nan
        if not least < value < below:
            limit = f" and below {below:g}" if below < math.inf else ""
            raise argparse.ArgumentTypeError(f"expected a number above {least:g}{limit}, found '{word}'")
        return value
    return checked


above_zero = above(0)  # such as a time or a length


def length_from_zero(word):
    """A length from 0 that may be infinite."""
    try:
        value = float(word)
    except ValueError:
        value = math.nan
    if not value >= 0:
        raise argparse.ArgumentTypeError(f"expected a length from 0, found '{word}'")
    return value
