"""Makes a film of the frames of a results file.

    tools/film RESULTS.h5 [-o FILM.mp4 | FILM.gif] [--fps 20] [--every N] [--stage NAME]
                          [--field stress_xx] [--joints [material | state | forces]] [--vectors [displacement | velocity]]
                          [--crosses] [--points] [--numbers] [--covers] [--window X1 Y1 X2 Y2] [--range LOW HIGH | full]
                          [--no-mesh] [--magnify FACTOR] [--units m,MPa=1e6] [--colours MAP] [--dpi N]

Colours and scales are those of all its frames, so that they do not change on the way. An .mp4 needs ffmpeg (Debian's ffmpeg), a .gif
Debian's python3-pil, which matplotlib brings along. Each frame is shown as
long: a run writes them at even times by output.interval.
"""
import pathlib
import subprocess

import matplotlib.pyplot as plt
from matplotlib.animation import FFMpegWriter, PillowWriter

from .arguments import above, beside, check_ending, ends_in_a_line, parser_for, whole_from
from .errors import PlotError
from .drawing import FIELDS, WHOLE, Frames, Panels, add_words_of_frames, extras_of, frames_of_stage, kind_of, look_of
from .records import Bar
from .units import units_of_files

WRITERS = {".mp4": (FFMpegWriter, "ffmpeg"), ".gif": (PillowWriter, "python3-pil")}  # and what Debian calls what they need


def writer_for(path, fps):
    """What writes a film of that name; ScreeError where its ending is not known or a program is missing."""
    check_ending(path, "a film", WRITERS)
    kind, package = WRITERS[path.suffix.lower()]
    if not kind.isAvailable():
        raise PlotError(f"{path}: expected {package} for a film of {path.suffix}, found none: apt-get install {package}, or give a "
                        f"name with {' or '.join(ending for ending in WRITERS if ending != path.suffix.lower())}")
    return kind(fps=fps)


def clear(axis):
    """Takes what was drawn from a panel; axes, title and legend stay."""
    for artist in [*axis.collections, *axis.lines, *axis.texts]:
        artist.remove()
    axis.scale_bars = []


def film(file, frames, path, fps, dpi, field, extras, look):
    """Writes the film of frames of a file, whole or not at all."""
    writer = writer_for(path, fps)
    panels = Panels([file], [(file, frame) for frame in frames], field, extras, look)
    figure, axes = panels.figure(1, 1, WHOLE)
    axis = axes[0, 0]
    digits = max(len(f"{time / look.units.of('[time]')[1]:.6g}") for time in file.times)
    picture, entries = panels.draw(axis, file, frames[-1])
    panels.frame_picture(figure, axes, picture, entries)
    axis.set_title(look.title(file, frames[-1]), fontsize=10)
    figure.canvas.draw()
    figure.set_layout_engine("none")  # as laid out once: the rest does not move
    bar, partial = Bar("film", len(frames), "frames"), path.with_name(f"{path.stem}.part{path.suffix}")
    try:
        with writer.saving(figure, str(partial), dpi):
            for frame in frames:
                clear(axis)
                panels.draw(axis, file, frame)
                axis.set_title(look.title(file, frame, digits), fontsize=10)
                writer.grab_frame()
                bar.advance(f"frame {frame}")
        partial.replace(path)
    except (OSError, ValueError, subprocess.CalledProcessError) as problem:
        raise PlotError(f"{path}: cannot write the film: {problem}") from None
    finally:
        plt.close(figure)
        partial.unlink(missing_ok=True)  # of a film that was stopped
    bar.end()


@ends_in_a_line
def main():
    parser = parser_for(__doc__)
    parser.add_argument("file", type=pathlib.Path, metavar="RESULTS")
    parser.add_argument("-o", "--output", type=pathlib.Path, metavar="FILM",
                        help="default: the file with .mp4, or .gif without ffmpeg")
    parser.add_argument("--fps", type=above(0, below=1000), default=20.0, help="frames in a second")
    parser.add_argument("--every", type=whole_from(1), default=1, metavar="N", help="each Nth frame")
    parser.add_argument("--stage", metavar="STAGE", help="the frames of a stage alone, by number or name")
    add_words_of_frames(parser)
    parser.set_defaults(dpi=120)
    given = parser.parse_args()
    output = given.output or beside(given.file, ".mp4" if FFMpegWriter.isAvailable() else ".gif")
    if kind_of(given.file) != "results":
        raise PlotError(f"{given.file}: expected a results file, found another")
    given.units = given.units or units_of_files(given.file)
    extras, look = extras_of(given), look_of(given)
    file = Frames(given.file, given.file.stem)
    frames = frames_of_stage(file, given.stage) if given.stage else range(len(file.times))
    film(file, frames[::given.every], output, given.fps, given.dpi, given.field or FIELDS[0], extras, look)
    print(output)
    return 0
