"""A program as a process: its seconds and its memory."""
import dataclasses
import subprocess
import sys

from ..errors import ScreeError

ROUNDS = 5
ENOUGH = 30  # seconds of rounds, after which no other begins

# Starts a program, asks it to stop (SIGTERM) after so many seconds, 0 for never, and tells on stderr how many it took and its peak
# memory in KiB. A process of its own, because a child's peak counts from that of the process it was forked from.
STARTER = """
import os, signal, sys, time
limit, *words = sys.argv[1:]
begun = time.monotonic()
child = os.posix_spawn(words[0], words, os.environ)
signal.signal(signal.SIGALRM, lambda *_: os.kill(child, signal.SIGTERM))
signal.setitimer(signal.ITIMER_REAL, float(limit))
_, status, used = os.wait4(child, 0)
print(time.monotonic() - begun, used.ru_maxrss, file=sys.stderr)
sys.exit(min(abs(os.waitstatus_to_exitcode(status)), 255))
"""


@dataclasses.dataclass
class Done:
    """How a process ended: its exit status, what it printed, what it said to stderr, wall-clock seconds, peak memory in MB."""

    status: int
    printed: str
    said: str
    seconds: float
    megabytes: float


def start(path, *words, limit=0.0):
    """Runs a program to its end, or until it was asked to stop after `limit` seconds."""
    done = subprocess.run([sys.executable, "-ISc", STARTER, str(limit), path, *words], capture_output=True, text=True)
    *said, figures = done.stderr.splitlines() or [""]
    try:
        seconds, kilobytes = map(float, figures.split())
    except ValueError:
        raise ScreeError(f"{path}: expected a program that starts, found: {figures}") from None
    return Done(done.returncode, done.stdout, "\n".join(said), seconds, kilobytes / 1024)


def run(path, *words):
    """What scree prints, seconds, peak memory in MB."""
    done = start(path, *words)
    if done.status:
        raise ScreeError(done.said.strip() or f"{path} failed")
    return done.printed, done.seconds, done.megabytes


def least_of_rounds(measure):
    """The least of each number that is measured, and the seconds of a round in front."""
    rounds, spent = [], 0
    while not rounds or (len(rounds) < ROUNDS and spent < ENOUGH):
        rounds.append(measure())
        spent += rounds[-1][0]
    return [min(column) for column in zip(*rounds)]
