"""Histories as columns: their values are those of the file, their names say what they are."""
import os
import pathlib

import numpy as np
import pytest
import scree
from scree import plot
from scree.errors import PlotError
from scree.histories import history_of, names_of_histories

SOURCE = pathlib.Path(os.environ["SCREE_SOURCE"])
SLOPE = SOURCE / "input" / "bench" / "slope" / "reg.geo"


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """A slope of 37 blocks with three measured points, ten steps."""
    folder = tmp_path_factory.mktemp("histories")
    (folder / "s.ana").write_text("1 10 1 3 0.01 0.005\n2600 25506 1e10 0.25 0 0 0 0 0 0 0 0 0\n15 0 0\n12 0 0\n12 0 0\n"
                                  "&deck dialect='short' /\n")
    return scree.run(SLOPE, folder / "s.ana", output=folder / "s.h5")


def test_columns_have_the_values_of_the_file_and_names(results):
    contacts = history_of(results, "contacts")
    assert contacts.names == ["open", "sliding", "locked"]
    np.testing.assert_array_equal(contacts.values, results.history.contacts)
    rotation = history_of(results, "rotation")
    assert rotation.names[36] == "block 37" and rotation.dimension == "rad" and len(rotation.names) == 37
    kinetic = history_of(results, "energy/kinetic")
    assert kinetic.names == [""] and kinetic.values.shape == (10, 1)
    moved = history_of(results, "measured_points/displacement")
    places = results.given_points("measured")
    assert moved.names[3] == f"point 2 at ({places[1, 0]:.4g}, {places[1, 1]:.4g}), y"
    np.testing.assert_array_equal(moved.values[:, 3], results.measured_points.displacement[:, 1, 1])
    stress = history_of(results, "measured_points/stress")
    assert stress.names[8].startswith("point 3 ") and stress.names[8].endswith("), xy")
    np.testing.assert_array_equal(stress.values[:, 8], results.measured_points.stress[:, 2, 2])
    for name in names_of_histories(results):
        found = history_of(results, name)
        assert found.values.shape == (10, len(found.names)) and found.description


def test_a_model_alone_has_no_history(results, tmp_path):
    scree.call("cut", SLOPE, results.path.parent / "s.ana", "-o", tmp_path / "cut.h5")
    with pytest.raises(PlotError, match="expected steps, found none"):
        history_of(scree.read(tmp_path / "cut.h5"), "area")


def test_what_is_no_history_is_said(results):
    with pytest.raises(PlotError, match="expected one of the histories area, .*measured_points/velocity, found 'weather'"):
        history_of(results, "weather")


def test_curves_are_named(results):
    figure = plot.draw_histories([results.path], ["contacts", "measured_points/displacement", "rotation", "area"])
    names = [[line.get_label() for line in axis.lines] for axis in figure.axes]
    assert names[0] == ["open", "sliding", "locked"] and len(names[1]) == 6 and names[2][0] == "block 1" and names[3] == ["s"]
    assert [axis.get_legend() is not None for axis in figure.axes] == [True, True, False, False]
    figure = plot.draw_histories([results.path, results.path], ["contacts"])
    assert [line.get_label() for line in figure.axes[0].lines][3:] == ["s, open", "s, sliding", "s, locked"]
