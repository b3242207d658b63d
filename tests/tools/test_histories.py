"""Histories as columns: their values are those of the file, their names say what they are."""
import os
import pathlib

import numpy as np
import pytest
import scree
from scree import drawing
from scree.errors import PlotError
from scree.histories import histories_of, names_of_histories
from scree.pages import facts
from scree.units import Units

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
    contacts, = histories_of(results, "contacts")
    assert contacts.names == ["open", "sliding", "locked"]
    np.testing.assert_array_equal(contacts.values, results.history.contacts)
    rotation, = histories_of(results, "rotation")
    assert rotation.names[36] == "block 37" and rotation.dimension == "rad" and len(rotation.names) == 37
    kinetic, = histories_of(results, "energy/kinetic")
    assert kinetic.names == [""] and kinetic.values.shape == (10, 1)
    moved, = histories_of(results, "measured_points/displacement")
    places = results.given_points("measured")
    assert moved.names[3] == f"point 2 at ({places[1, 0]:.4g}, {places[1, 1]:.4g}), y"
    np.testing.assert_array_equal(moved.values[:, 3], results.measured_points.displacement[:, 1, 1])
    stress, = histories_of(results, "measured_points/stress")
    assert stress.names[8].startswith("point 3 ") and stress.names[8].endswith("), xy")
    np.testing.assert_array_equal(stress.values[:, 8], results.measured_points.stress[:, 2, 2])
    for name in names_of_histories(results):
        for found in histories_of(results, name):
            assert found.values.shape == (10, len(found.names)) and found.description


def test_angular_momentum_has_a_unit_of_its_own(results):
    """Decks in m and Pa: of a slice of a metre in mm, kPa and s momentum is 1 N s = 1e-3 kPa m2 s = 1e3 kPa mm2 s, and angular momentum
    1 N m s = 1e-3 kPa m3 s = 1e6 kPa mm3 s."""
    along, angular = histories_of(results, "momentum")
    assert (along.names, angular.names) == (["x", "y"], ["angular"])
    assert (along.dimension, angular.dimension) == ("mass*length/time", "mass*length^2/time")
    np.testing.assert_array_equal(np.hstack([along.values, angular.values]), results.history.momentum)
    units = Units("mm=1e-3,kPa=1e3,s")
    figure = drawing.draw_histories([results.path], ["momentum"], units)
    assert [axis.get_ylabel() for axis in figure.axes] == ["[kPa mm$^2$ s]", "[kPa mm$^3$ s]"]
    assert figure.axes[0].lines[1].get_ydata() == pytest.approx(1e3 * results.history.momentum[:, 1], rel=1e-12)
    assert figure.axes[1].lines[0].get_ydata() == pytest.approx(1e6 * results.history.momentum[:, 2], rel=1e-12)
    panels = [panel for panel in facts.charts(results, units) if "momentum" in panel["title"]]
    assert [panel["title"].split("[")[1] for panel in panels] == ["kPa mm² s]", "kPa mm³ s]"]
    assert panels[1]["series"][0]["values"][-1] == pytest.approx(1e6 * results.history.momentum[-1, 2], rel=1e-6)


def test_a_model_alone_has_no_history(results, tmp_path):
    scree.call("cut", SLOPE, results.path.parent / "s.ana", "-o", tmp_path / "cut.h5")
    with pytest.raises(PlotError, match="expected steps, found none"):
        histories_of(scree.read(tmp_path / "cut.h5"), "area")


def test_what_is_no_history_is_said(results):
    with pytest.raises(PlotError, match="expected one of the histories area, .*measured_points/velocity, found 'weather'"):
        histories_of(results, "weather")


def test_curves_are_named(results):
    figure = drawing.draw_histories([results.path], ["contacts", "measured_points/displacement", "rotation", "area"])
    names = [[line.get_label() for line in axis.lines] for axis in figure.axes]
    assert names[0] == ["open", "sliding", "locked"] and len(names[1]) == 6 and names[2][0] == "block 1" and names[3] == ["s"]
    assert [axis.get_legend() is not None for axis in figure.axes] == [True, True, False, False]
    figure = drawing.draw_histories([results.path, results.path], ["contacts"])
    assert [line.get_label() for line in figure.axes[0].lines][3:] == ["s, open", "s, sliding", "s, locked"]
