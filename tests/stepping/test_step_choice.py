"""Steps that a vertex may go only so far in, a run of so many steps, and the sizes that Shi's programs choose."""
import os
import pathlib

import numpy as np
import pytest
import scree

CLASSIC = pathlib.Path(os.environ["SCREE_SOURCE"]) / "tests" / "data" / "classic"
HALF = 0.5  # of the size of the falling block, 1 x 1
G = 10.0


def fall(folder, *settings):
    """The free fall of one block: histories of time and step size, rejected tries, drop at the end."""
    f = scree.run(CLASSIC / "freefall.geo", CLASSIC / "freefall.ana", output=folder / "x.h5",
                  settings=["output.every=1", "integrator.gamma=0.5", *settings])
    y = f.bodies.centroid[:, 0, 1]
    return f.history.time, f.history.step_size, f.history.rejected, y[0] - y


def test_no_vertex_goes_farther_in_a_step_than_it_may(tmp_path):
    time, size, rejected, drop = fall(tmp_path, "step.travel=0.05", "step.end_time=0.5")
    assert np.diff(drop).max() <= 0.05 * HALF and rejected.sum() > 0
    assert time[-1] == 0.5 and size.min() < 0.01
    np.testing.assert_allclose(drop[1:], G * time**2 / 2, rtol=1e-12)  # whatever the steps
    _, _, rejected, _ = fall(tmp_path, "step.end_time=0.5")
    assert rejected.sum() == 0


def test_a_limit_that_cannot_be_kept_ends_the_run(tmp_path):
    with pytest.raises(scree.RunFailed, match="step.travel.*least") as failed:
        fall(tmp_path, "step.travel=0.001", "step.least=0.005")
    assert failed.value.status == 1


def test_a_run_ends_after_a_number_of_steps(tmp_path):
    time, _, _, _ = fall(tmp_path, "step.count=7")
    assert len(time) == 7 and time[-1] == pytest.approx(0.07)


def test_chosen_steps_go_as_far_as_they_may(tmp_path):
    """From rest with the weight, t^2 = 2 g2 w0/g; then they grow by 1.3 until a vertex goes three times as far."""
    time, size, rejected, drop = fall(tmp_path, "step.control=shi", "step.count=40")
    allowed = 0.05 * HALF
    assert size[0] == pytest.approx(np.sqrt(2 * allowed / G))
    assert len(size) == 40 and rejected.sum() > 0
    assert np.diff(drop).max() <= 3 * allowed
    np.testing.assert_allclose(drop[1:], G * time**2 / 2, rtol=1e-12)
    assert (size[1:] / size[:-1]).max() <= 1.3 * (1 + 1e-12)
