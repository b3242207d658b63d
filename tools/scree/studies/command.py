"""Runs a scene with many numbers, and makes one table of what the runs came to (doc/studies.md).

    tools/study TABLE [[GEOMETRY] ANALYSIS] [-o FOLDER] [--to FILE] [--jobs N] [--set GROUP.NAME=VALUE] [--keep]
    tools/study TABLE ... --draw QUANTITY [--units m,MPa=1e6,s]   draws a column of the table against each number that varies
    tools/study TABLE ... --slurm | --snakemake  writes what makes the runs elsewhere, runs nothing
    tools/study TABLE ... --part I/N             every Nth run from number I (0 to N-1), no table
    tools/study TABLE ... --collect              makes the table of the runs that there are

TABLE is a CSV file, its first line names as --set takes them and a run in each other, or a TOML file with lists, ranges and
samples. Each run goes into a record of its own in FOLDER/runs: the same command goes on where it was stopped, and makes again
what another program, deck or setting would change. FOLDER/table.csv, or the FILE of --to, with .csv or .parquet, is written when all runs
are there. Parquet needs pyarrow (pip install '.[parquet]').
"""
import argparse
import contextlib
import os
import pathlib
import shlex
import signal
import sys

from ..arguments import STOPPED, ends_in_a_line, parser_for, say, whole_from
from ..errors import ScreeError
from ..units import Units, add_units, units_of_files
from .output import check_output, write_table
from .runs import Study
from .tables import read_table

MOST_PARTS = 1000  # of an array job, as Slurm takes by default

SLURM = """#!/bin/bash
#SBATCH --job-name="{name}"
#SBATCH --array=0-{last}
#SBATCH --ntasks=1
#SBATCH --cpus-per-task=1
#SBATCH --output="{folder}/slurm-%A_%a.out"
# {runs} runs, made by: sbatch {script}; what is complete is not made again. Then the table: {command} --collect
exec {command} --jobs 1 --part "$SLURM_ARRAY_TASK_ID/{parts}"
"""

SNAKEMAKE = """# {runs} runs, made by: snakemake --snakefile {script} --cores all
PARTS = {parts}

rule table:
    input: expand("{folder}/parts/{{part}}", part=range(PARTS))
    output: "{table}"
    shell: {collect}

rule part:
    output: touch("{folder}/parts/{{part}}")
    shell: {part}
"""


def part_of(text):
    """I/N as two whole numbers."""
    number, _, parts = text.partition("/")
    if not (number.isdigit() and parts.isdigit() and int(number) < int(parts)):
        raise argparse.ArgumentTypeError(f"expected I/N with I from 0 to N-1, found '{text}'")
    return int(number), int(parts)


def arguments():
    parser = parser_for(__doc__)
    parser.add_argument("table", type=pathlib.Path, metavar="TABLE")
    parser.add_argument("decks", nargs="*", type=pathlib.Path, metavar="DECK", help="default: those of the table, from its folder")
    parser.add_argument("-o", "--output", type=pathlib.Path, metavar="FOLDER", help="default: the name of the table, here")
    parser.add_argument("--to", type=pathlib.Path, metavar="FILE", help="the table, .csv or .parquet; default: FOLDER/table.csv")
    parser.add_argument("--set", action="append", default=[], metavar="GROUP.NAME=VALUE", help="a setting of every run")
    parser.add_argument("--jobs", type=whole_from(1), default=len(os.sched_getaffinity(0)), help="runs at once; default: the processors")
    parser.add_argument("--keep", action="store_true", help="keeps the results files of the runs")
    parser.add_argument("--draw", metavar="QUANTITY", help="FOLDER/QUANTITY.png of a column of the table")
    add_units(parser)
    instead = parser.add_mutually_exclusive_group()
    instead.add_argument("--slurm", action="store_true", help="writes FOLDER/study.sbatch, an array job")
    instead.add_argument("--snakemake", action="store_true", help="writes FOLDER/Snakefile")
    instead.add_argument("--part", type=part_of, metavar="I/N", help="makes a part of the runs")
    instead.add_argument("--collect", action="store_true", help="runs nothing, makes the table")
    parser.add_argument("--scree", metavar="PROGRAM", help="the program; default: that of $SCREE, or of build/release")
    given = parser.parse_args()
    given.output = given.output or pathlib.Path(given.table.stem)
    given.to = given.to or given.output / "table.csv"
    return given


def words_of(given, study):
    """The command that makes the study from anywhere."""
    words = [pathlib.Path(sys.argv[0]).absolute(), given.table.absolute(), *(deck.absolute() for deck in given.decks), "-o",
             given.output.absolute(), "--to", given.to.absolute(), *(word for one in given.set for word in ("--set", one)), *(["--keep"] if given.keep else []),
             "--scree", study.path]
    return shlex.join(map(str, words))


def write_job(given, study):
    """Writes what makes the runs elsewhere: an array job of Slurm, or a Snakefile."""
    runs, folder = len(study.keys), given.output.absolute()
    parts, command = min(runs, MOST_PARTS), words_of(given, study)
    script = folder / ("study.sbatch" if given.slurm else "Snakefile")
    facts = dict(runs=runs, parts=parts, last=parts - 1, folder=folder, table=given.to.absolute(), command=command, script=shlex.quote(str(script)),
                 name=given.table.stem)
    if given.snakemake:
        escaped = command.replace("{", "{{").replace("}", "}}")  # Snakemake fills in what is in braces
        facts.update(collect=repr(f"{escaped} --collect"), part=repr(f"{escaped} --jobs 1 --part {{wildcards.part}}/{parts}"))
    script.write_text((SLURM if given.slurm else SNAKEMAKE).format(**facts))
    print(f"{script}: {runs} runs in {parts} parts; " +
          ("sbatch it, then --collect" if given.slurm else "snakemake --snakefile it"))
    return 0


def tell(study, made):
    """Says what the runs came to; returns the exit status, 1 where some are not there."""
    found = [study.record(number) for number in range(len(study.keys))]
    states = [one["status"] if one else "not run" for one in found]
    others = [state for state in states if state not in ("complete", "not run")]
    seconds = [one["seconds"] for one in found if one]
    print(f"{len(states)} runs: {states.count('complete')} complete, {len(others)} ended before, "
          f"{states.count('not run')} not run; {made} made now" +
          (f"; {sum(seconds) / len(seconds):.3g} s each" if seconds else ""))
    if others:
        print(f"run {states.index(others[0]) + 1}: {others[0]}")
    return int("not run" in states)


def study_of(given):
    table = read_table(given.table)
    decks = given.decks or table.decks
    if not decks:
        raise ScreeError(f"{given.table}: expected a deck, in the table or after it, found none")
    return Study(table, [deck.absolute() for deck in decks], given.set, given.output.absolute(), given.scree, given.keep)


def check_drawing(given, header):
    """ScreeError, before any run, where a picture cannot be drawn: there is no table to draw from, or no such column in it."""
    without = next((f"--{word}" for word in ("slurm", "snakemake", "part") if getattr(given, word) not in (None, False)), None)
    if without:
        raise ScreeError(f"--draw: expected a study that writes its table, found {without}: draw with --collect, when all runs are there")
    if given.draw not in header:
        raise ScreeError(f"--draw: expected a column of the table: {', '.join(header)}; found '{given.draw}'")


def work(given):
    """Does what is asked; returns the exit status."""
    study = study_of(given)
    units = Units(given.units or (units_of_files(*study.decks, path=given.scree) if given.draw else None))
    check_output(given.to)
    header = study.header()
    if given.draw is not None:
        check_drawing(given, header)
    if given.slurm or given.snakemake:
        return write_job(given, study)
    numbers = range(len(study.keys)) if given.part is None else range(given.part[0], len(study.keys), given.part[1])
    made, stopped = (0, 0) if given.collect else study.run(numbers, given.jobs)
    if stopped:
        raise ScreeError(f"{stopped} runs were ended by a signal: the same command goes on")
    if given.part is not None:
        return 0
    lines = study.lines()
    write_table(given.to, header, lines)
    status = tell(study, made)
    print(given.to.absolute())
    if given.draw:
        from .picture import draw, drawn  # here, as matplotlib takes a second to begin
        figure = drawn(study.table.names, header, lines, given.draw, study.dimensions(), units)
        print(draw(figure, given.output / f"{given.draw.replace('/', '-')}.png"))
    return status


@ends_in_a_line
def main():
    given = arguments()
    signal.signal(signal.SIGTERM, lambda number, _: sys.exit(128 + number))
    try:
        return work(given)
    except KeyboardInterrupt:
        with contextlib.suppress(OSError):
            say("stopped; the same command goes on")
        return STOPPED
