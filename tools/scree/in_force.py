"""Settings in force in each stage of a scene, by what `scree explain` prints and what results files hold."""
from __future__ import annotations

import re
from collections.abc import Iterable

import numpy as np

from .results import Results

LINE = re.compile(r"^\s*(\w+\.\w+) = (.*?)(?: \[\S*\])?  \(.*\)$")  # NAME = VALUE [dimension]  (where it is given)
STAGE = re.compile(r"^stage (\d+)(?: \((.*?)\))?: (static|dynamic)(.*)$", re.M)
CHANGE = re.compile(r"; (?:no (\w+\.\w+)|(\w+\.\w+) = ([^;]*))")
JOINT = re.compile(r"^joint material \d+.*\n  friction angle \(phi\): (\S+).*\n  cohesion \(c\): (\S+).*\n  tensile strength \(T\): (\S+)",
                   re.M)

Settings = dict[str, str]  # values by GROUP.NAME


def settings_of_lines(lines: Iterable[str]) -> Settings:
    """Values of settings by GROUP.NAME, of lines such as `joints.phi = 30 [degree]  (slope.ana:8)`."""
    return {found[1]: found[2] for line in lines if (found := LINE.match(line))}


class Explained:
    """What `scree explain` says of a scene: `joints` has friction angle, cohesion and tensile strength of the row of each joint material,
    `stages` the settings in force in each stage, `names` the names of the stages, `kinds` whether each is static or dynamic."""

    def __init__(self, said: str) -> None:
        self.joints = [tuple(map(float, row)) for row in JOINT.findall(said)]
        self.stages: list[Settings] = [settings_of_lines(said.partition("\nsettings\n")[2].splitlines())]
        carried = re.search(r"\(k01\): (\S+)", said)
        self.names, self.kinds = ["stage 1"], ["static" if carried and float(carried[1]) == 0 else "dynamic"]
        for number, name, kind, changes in STAGE.findall(said):
            now = dict(self.stages[-1])
            for gone, changed, value in CHANGE.findall(changes):
                now.pop(gone, None)
                now |= {changed: value} if changed else {}
            self.stages.append(now)
            self.names.append(name or f"stage {number}")
            self.kinds.append(kind)


def numbers(settings: Settings, name: str) -> list[float]:
    """The numbers of a setting; none where it is not given."""
    value = settings.get(name, "none")
    return [] if value == "none" else [float(word) for word in value.replace(",", " ").split()]


def settings_of_frame(results: Results, frame: int = -1) -> Settings:
    """The settings in force in a frame of results; in stages after the first those that decks or the command line give."""
    stage = int(results.frame_stages[results._frame(frame)])
    return settings_of_lines(map(str, np.ravel(results[f"stages/settings_{stage}"] if stage > 1 else results.scene.settings)))
