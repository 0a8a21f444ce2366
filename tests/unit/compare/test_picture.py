"""The picture of a comparison: its texts, their places, and its views."""

import numpy as np
import pytest
from matplotlib.image import imread

from pathgene.host.compare.picture import draw
from pathgene.host.report.style import save
from tests.support.host.pictures import assert_texts_apart, texts_of

from .conftest import made_up_runs


RNG = np.random.default_rng(3)


def sample(mean, spread=0.01, runs=50, **sizes):
    return made_up_runs(RNG.normal(mean, spread, runs), **sizes)


FAILING = made_up_runs([*RNG.normal(1.45, 0.01, 44), *[0.002] * 6])
LONG = "ga-fpga:board=sim:?sim=icarus&max_waypoints=20:link_mode=recipe:initial_draws=1"
FIELDS = {
    "one": {"ga-fpga": sample(1.48)},
    "two": {"ga-fpga": sample(1.48), "ga-pc": sample(1.46)},
    "some infeasible": {"ga-fpga": sample(1.48), "ga-pc": FAILING},
    "all infeasible": {"ga-fpga": sample(0.01, 0.001), "ga-pc": sample(0.02, 0.001)},
    "five, long names": {
        LONG: sample(1.48),
        "ga-pc:max_waypoints=8:population=64": FAILING,
        "fpa-2opt:engine=threads:init=astar": sample(1.52, 0.002, each=512, first=512),
        "astar": made_up_runs([1.51] * 50, generations=0, first=1),
        "ga-dp": sample(1.4, each=90),
    },
    "one run": {"ga-fpga": made_up_runs([1.48]), "ga-pc": made_up_runs([1.46])},
    "none of one": {"ga-fpga": sample(1.48), "ga-pc": []},
}


@pytest.fixture(scope="module", params=FIELDS)
def drawn(request, report_of):
    report = report_of(FIELDS[request.param])
    figure = draw(report)
    figure.canvas.draw()
    return report, figure


def test_texts_neither_overlap_nor_leave_the_figure(drawn):
    assert_texts_apart(drawn[1])


def test_has_all_names_and_counts(drawn):
    report, figure = drawn
    shown = [text.replace("\n", "") for text, _ in texts_of(figure)]
    for planner in report["planners"]:
        assert planner["label"] in shown
        runs = planner["statistics"]["runs"]
        count = f"{planner['statistics']['feasible']}/{runs}feasible" if runs else "no runfinished"
        assert count in shown


def test_counts_runs_out_of_view(report_of):
    shown = [text for text, _ in texts_of(draw(report_of(FIELDS["some infeasible"])))]
    assert shown.count("← 6 below 1") == 1
    boxes = draw(report_of(FIELDS["some infeasible"])).axes[0]
    assert boxes.get_xlim()[0] > 1.4
    everything = draw(report_of(FIELDS["all infeasible"]))
    assert everything.axes[0].get_xlim()[0] < 0.01
    assert not any("below 1" in text for text, _ in texts_of(everything))


@pytest.mark.parametrize(
    ("field", "label", "scale"),
    [("two", "generation", "linear"), ("five, long names", "evaluations", "log")],
)
def test_convergence_uses_a_comparable_axis(report_of, field, label, scale):
    convergence = draw(report_of(FIELDS[field])).axes[1]
    assert (convergence.get_xlabel(), convergence.get_xscale()) == (label, scale)


def test_p_values_of_two_planners_are_in_the_subtitle(report_of):
    report = report_of(FIELDS["two"])
    (subtitle,) = (text for text, _ in texts_of(draw(report)) if "Mann-Whitney" in text)
    for test in ("welch", "mann_whitney"):
        assert f"p = {report['pairs'][0][test]['p']:.2g}" in subtitle


def test_writes_a_picture(report_of, tmp_path):
    save(draw(report_of(FIELDS["two"])), tmp_path / "compare.png")
    assert imread(tmp_path / "compare.png").shape[1] == 1927
    assert [file.name for file in tmp_path.iterdir()] == ["compare.png"]
