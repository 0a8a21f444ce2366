"""The table of options: a planted row appears in every place that is made from the table."""

import argparse
import json
import subprocess
import sys

import pytest

from pathgene.host.cli.parser import build_parser
from pathgene.host.errors import InputError
from pathgene.host.mission.problem_file import parse_problem
from pathgene.host.options import kinds
from pathgene.host.options.table import NAMED, OPTIONS, RULES
from pathgene.host.problem.rules import Rules


# Plants a row among the planners' own options and one among the options of a problem, before
# anything reads the table, and prints where they are found.
PLANTED = """
import dataclasses, importlib.util, json, sys
from pathlib import Path

import pathgene.host.options
from pathgene.host.planners import PLANNERS

make = PLANNERS["ga-pc"].constructor
PLANNERS["ga-pc"] = dataclasses.replace(
    PLANNERS["ga-pc"],
    options=(*PLANNERS["ga-pc"].options, "bird_width"),
    constructor=lambda bird_width=3, **options: make(**options),
)
spec = importlib.util.find_spec("pathgene.host.options.table")
text = Path(spec.origin).read_text()
for begin, row in (
    ("_OWN = (", '_own("bird_width", INTEGER, "width of a bird", "3", "8"),'),
    ("_PROBLEM = (", 'Option(name="bird_m", kind=NUMBER, meaning="distance to birds", '
     'group="problem", table="mission", metavar="M", default_text="none", example="5.0"),'),
):
    assert text.count(begin) == 1
    text = text.replace(begin, begin + row)
table = importlib.util.module_from_spec(spec)
sys.modules[spec.name] = table
exec(compile(text, spec.origin, "exec"), table.__dict__)
pathgene.host.options.table = table

import argparse

from pathgene.host.cli.parser import build_parser
from pathgene.host.compare.entrants import parse_entrants
from pathgene.host.mission.problem_file import markdown, parse_problem, problem_text, template
from pathgene.host.web.desk.form import fields_of, planner_fields

(commands,) = (a for a in build_parser()._actions if isinstance(a, argparse._SubParsersAction))
helps = {name: parser.format_help() for name, parser in commands.choices.items()}
(entrant,) = parse_entrants("ga-pc:bird_width=5", {}, {})
values = parse_problem("[mission]\\nbird_m = 7.5\\n[planner]\\nbird_width = 4", Path())
print(json.dumps({
    "own in help": sorted(name for name, text in helps.items() if "--bird-width N" in text),
    "problem in help": sorted(name for name, text in helps.items() if "--bird-m M" in text),
    "problem file": values,
    "written": problem_text(values, Path()).splitlines()[-5:],
    "docs": [line for line in markdown().splitlines() if "bird" in line],
    "template": [line for line in template().splitlines() if "bird" in line],
    "desk": [field.label for field in planner_fields("ga-pc") + fields_of("mission")
             if "bird" in field.label],
    "compare": dict(entrant.own),
}))
"""


def test_a_row_is_found_in_every_place():
    done = subprocess.run([sys.executable, "-c", PLANTED], capture_output=True, text=True)
    assert done.stderr == ""
    assert json.loads(done.stdout) == {
        "own in help": ["batch", "compare", "plan"],
        "problem in help": ["check", "compare", "diagnose", "mend", "plan"],
        "problem file": {"bird_m": 7.5, "bird_width": 4},
        "written": ["[mission]", "bird_m = 7.5", "", "[planner]", "bird_width = 4"],
        "docs": [
            "| `bird_m` | distance to birds; a number | none | `--bird-m` |",
            "| `bird_width` | for ga-pc: width of a bird; a whole number | 3 | `--bird-width` |",
        ],
        "template": [
            "# Distance to birds (none).",
            "# bird_m = 5.0",
            "# For ga-pc: width of a bird (3).",
            "# bird_width = 8",
        ],
        "desk": ["bird width", "bird m"],
        "compare": {"bird_width": 5},
    }


def test_names_and_flags_are_unique():
    named = [option for option in OPTIONS if option.group != "file"]
    assert len(named) == len(NAMED) == len({option.flag for option in named})


def test_defaults_of_rules_are_the_defaults_of_the_class():
    rules = Rules()
    assert NAMED["clearance"].default_text == "30"
    assert NAMED["reserve"].default_text == "10"
    for option in RULES.values():
        if option.table == "rules":
            value = getattr(rules, option.field)
            stated = None if option.default_text == "none" else float(option.default_text)
            assert stated == (None if value is None else option.of_field(value))


def test_a_value_is_given_once_in_each_parse():
    parser = build_parser()
    for _ in range(2):
        assert parser.parse_args(["plan", "--seed", "3"]).seed == 3
    with pytest.raises(InputError, match=r"^Argument --seed: may be given only once; see "):
        parser.parse_args(["plan", "--seed", "3", "--seed", "3"])
    assert isinstance(parser, argparse.ArgumentParser)


def test_a_problem_file_names_a_directory(tmp_path):
    with pytest.raises(
        InputError, match=r"^out in \[output\] must be the path of a file, not ''\.$"
    ):
        parse_problem('[output]\nout = ""', tmp_path)


@pytest.mark.parametrize("text", ["nan", "sea", ""])
def test_a_bad_water_level_is_refused_in_words(text):
    with pytest.raises(argparse.ArgumentTypeError, match="must be a height in metres or none, not"):
        kinds.WATER_LEVEL.parse(text)
