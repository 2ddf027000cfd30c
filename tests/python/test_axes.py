"""Results that are drawn into axes of matplotlib."""

from __future__ import annotations

from typing import Any

import matplotlib
import numpy as np
import pytest

import stickslip

matplotlib.use("Agg")

from matplotlib.figure import Figure  # noqa: E402


def test_probabilities_over_one_axis_are_a_line_with_its_interval(small: dict[str, Any]) -> None:
    run = stickslip.run(small, progress=False)
    ax = Figure().subplots()
    line = run.plot(ax=ax, at={"rotating_speed": 15.0, "preload": 0.2}, target=0.05, title="15 rad/s")
    surface = run.surface()
    rows = surface[(surface["rotating_speed_rad_s"] == 15.0) & (surface["preload"] == 0.2)]
    assert np.array_equal(line.get_xdata(), rows["static_friction"])
    assert np.array_equal(line.get_ydata(), rows["p_unstable"])
    assert ax.get_xlabel() == "expected static friction coefficient" and ax.get_title() == "15 rad/s"
    [band] = ax.collections
    edges = band.get_paths()[0].vertices
    assert {*rows["p_low"], *rows["p_high"]} <= set(edges[:, 1])


def test_probabilities_over_two_axes_are_filled_contours(small: dict[str, Any]) -> None:
    run = stickslip.run(small, progress=False)
    ax = Figure().subplots()
    filled = run.plot(ax=ax, at={"rotating_speed": 15.0}, target=0.5)
    assert filled.filled and list(filled.levels)[:2] == [0.0, 0.01]
    assert ax.get_ylabel().startswith("expected preload")
    assert ax.get_xlim() == (0.3, 0.45) and ax.get_ylim() == (0.1, 0.2)


def test_the_axis_of_standard_deviations_has_the_name_of_a_job(small: dict[str, Any]) -> None:
    small["axes"] = {"rotating_speed": 15.0, "preload": [0.2, 0.1], "static_friction": 0.4}
    small["random"]["relative_std"] = [0.1, 0.2]
    run = stickslip.run(small, progress=False)
    line = run.plot(ax=Figure().subplots(), at={"relative_std": 0.1})
    surface = run.surface().sort_values("preload")
    # Whatever the order of the values in the job.
    assert line.get_xdata().tolist() == [0.1, 0.2]
    assert np.array_equal(line.get_ydata(), surface[surface["std_preload"] == 0.1]["p_unstable"])
    with pytest.raises(ValueError, match="relative_std = 0.3 is no value of this axis; it has 0.1, 0.2"):
        run.plot(ax=Figure().subplots(), at={"relative_std": 0.3})


def test_what_cannot_be_drawn_into_axes_is_refused(small: dict[str, Any]) -> None:
    run = stickslip.run(small, progress=False)
    ax = Figure().subplots()
    with pytest.raises(ValueError, match="one or two axes .* choose a value with at={'rotating_speed': ...}"):
        run.plot(ax=ax)
    with pytest.raises(ValueError, match="16.0 is no value of this axis; it has 10, 15, 20"):
        run.plot(ax=ax, at={"rotating_speed": 16.0})
    with pytest.raises(ValueError, match="there is no axis 'speed'"):
        run.plot(ax=ax, at={"speed": 15.0})
    with pytest.raises(TypeError, match="only at, target and title"):
        run.plot(ax=ax, of="inputs")  # type: ignore[call-overload]


def test_a_motion_is_its_displacement_over_time() -> None:
    motion = stickslip.trajectory(operating_point={"rotating_speed": 10.0}, disc="rigid", horizon=50)
    ax = Figure().subplots()
    table = motion.table()
    line = motion.plot(ax=ax, start=table["time_s"][10], title="Onset")
    assert np.array_equal(line.get_ydata(), table["x_mm"][10:])
    assert ax.get_xlabel() == "time, ms" and ax.get_title() == "Onset"
    with pytest.raises(TypeError, match="only start, end and title"):
        motion.plot(ax=ax, columns=1)  # type: ignore[call-overload]
