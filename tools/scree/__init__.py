"""Makes models, runs scree and reads its results.

    import scree

    r = scree.read("t4.h5")                  what a run wrote
    r = scree.run("t4.ana", set={"step.size": 0.01})   runs a deck, then reads; raises scree.RunFailed with the program's words
    m = scree.Model("slope"); ...; r = m.run()                         a model by words (doc/model.md)
    r.history.time, r.history.rotation       at the end of each step: arrays (s), (s, b)
    r.history.energy.kinetic
    r.bodies.centroid, r.bodies.stress       of each block in each frame: (f, b, 2), (f, b, 3)
    r.measured_points.displacement           (s, p, 2)
    r.times, r.polygons(-1), r.stress(0)     frames: their times, the polygons and stresses of the elements
    r.contacts_of(-1).force                  closed contacts of a frame
    r.table_of_steps(), r.table_of_blocks(-1), r.table_of_contacts(-1)     the same as tables of pandas
    r.shapes(-1)                             polygons of a frame, for shapely

The names are those of the file, which doc/results.md explains; `dir(r.history)` lists what is there. The program is that of the
variable SCREE, else that of build/release.
"""
from .errors import ModelError, ProgramMissing, ResultsError, RunFailed, ScreeError
from .ground_motion import Spectrum, response_spectrum
from .model import Model, arc
from .program import Runner, call, cut, program, run, version
from .results import Contacts, Group, Results, read
from .verbs import FactorOfSafety, film, fs, laboratory, plot, report, rockfall, study

__all__ = ["Contacts", "FactorOfSafety", "Group", "Model", "ModelError", "ProgramMissing", "Results", "ResultsError", "RunFailed", "Runner",
           "ScreeError", "Spectrum", "arc", "call", "cut", "film", "fs", "laboratory", "plot", "program", "read", "report", "response_spectrum",
           "rockfall", "run", "study", "version"]
