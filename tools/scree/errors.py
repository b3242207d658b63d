"""What goes wrong, in one line each."""
import os
import re


def reason_of(problem):
    """Why a file cannot be opened, read or written, by an OSError: in words of the system, else in the last ones of HDF5, which stand in
    brackets."""
    words = str(problem).splitlines()[0]
    return os.strerror(problem.errno) if problem.errno else re.sub(r"^Unable to [a-z ]+\((.+)\)$", r"\1", words)


class ScreeError(Exception):
    """What went wrong, for the user."""


class ResultsError(ScreeError):
    """Not a results file of scree, or not the one that was read."""


class ProgramMissing(ScreeError):
    """There is no program to run."""


class RunFailed(ScreeError):
    """The program ended with an error: its last words. `status` is its exit status, `said` all that it wrote to stderr."""

    def __init__(self, words, status, said):
        super().__init__(words)
        self.status, self.said = status, said


class ModelError(ScreeError):
    """What is wrong in the words that make a model, or in a deck that a model is read from."""


class NoFactor(ScreeError):
    """A scene has no factor of safety that a search finds."""


class PlotError(ScreeError):
    """What cannot be drawn."""
