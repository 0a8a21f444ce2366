"""The claims of README match the stored results of the benchmarks."""

import json
import re
from statistics import mean

import pytest

from bench.pages import FIGURES
from tests.docs.pages import PAGES, ROOT


WORDS = ("no", "one", "two", "three", "four", "five", "six", "seven", "eight")


def readme():
    return re.sub(r"\s+", " ", (ROOT / "README.md").read_text("utf-8"))


def kept(name):
    content = json.loads((FIGURES / f"{name}.json").read_text("utf-8"))
    return [content, *content.get("further", ())]


def test_is_short():
    assert len((ROOT / "README.md").read_text("utf-8").splitlines()) <= 150


def test_claims_what_holds_on_held_out_ground():
    counts = []
    for table in kept("held-out")[:2]:
        *problems, row = table["rows"]
        assert row["problem"] == "better than astar"
        better = [row[f"{variant}"] for variant in list(row)[2:]]
        assert all(cell.endswith(f" of {len(problems)}") for cell in better)
        alone, polished, _, longer, _ = (WORDS[int(cell.split()[0])] for cell in better)
        counts.append((alone, polished, longer))
        assert len(problems) == WORDS.index("eight")
    (alone, polished, longer), safe = counts
    longer = "all eight" if longer == "eight" else longer
    assert (
        f"on {alone} of eight problems, on {polished} with the host's polish, and on {longer} with "
        f"50 ms and polish; with 30 m, on {safe[0]}, {safe[1]} and {safe[2]}"
    ) in readme()


def test_claims_what_holds_on_generated_problems():
    paper, safe = (table["rows"][-1] for table in kept("untuned"))
    assert paper["kind"] == safe["kind"] == "all"
    problems = int(paper["problems"])
    assert problems == int(safe["problems"])
    for table in kept("real-maps"):
        assert int(table["rows"][-1]["below astar"]) == 0
    assert [int(row["below astar"]) for row in (paper, safe)] == [0, 0]
    assert [int(row["not feasible"]) for row in (paper, safe)] == [0, 0]
    text = " ".join(readme().split())
    assert f"on [{problems} generated problems]" in text
    assert (
        f"none is below `astar`, and in paper mode {paper['below peers']} of {paper['problems']} "
        "are below the best of four planners of OMPL"
    ) in text


@pytest.mark.parametrize("page", PAGES)
def test_links_lead_to_files(page):
    """Sphinx checks the links between the pages of the site alone."""
    text = (ROOT / page).read_text("utf-8")
    links = [link for link in re.findall(r"\]\(([^)#\s]+)", text) if "://" not in link]
    folder = (ROOT / page).parent
    assert [link for link in links if not (folder / link).exists()] == []


def test_says_how_many_cycles_a_generation_takes():
    (table,) = (table for table in kept("chip") if table["title"].startswith("Cycles of a"))
    cycles = [int(row["cycles per generation"]) for row in table["rows"]]
    assert f"about {round(mean(cycles), -1):.0f} cycles per generation" in readme()


def test_says_how_long_a_replan_takes():
    table, _ = kept("replan")
    (row,) = (row for row in table["rows"] if row["planner"] == "ga-chip, model:")
    whole, line = (
        float(row[column].split(" / ")[0]) for column in ("new path after ms", "chip and line ms")
    )
    assert f"the autopilot after {whole:.0f} ms" in readme()
    assert f"{line:.1f} ms together" in readme()
    (table,) = kept("chip-replans")
    kilocycles = [
        float(row["kilocycles, mean"])
        for row in table["rows"]
        if row["replan"].endswith(("and a repair", "and a retry"))
    ]
    # Cycles at 100 MHz.
    assert f"after {max(kilocycles) / 100:.1f} ms of its own time" in readme()
