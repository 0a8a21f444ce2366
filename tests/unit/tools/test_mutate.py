"""The mutation tester: its draw, its alterations, its verdicts and its report."""

import ast
import collections
import dataclasses
import json
import shutil
import textwrap
from pathlib import Path

import pytest

from tools.mutate import has_killer, is_settled, main, read, report
from tools.mutation.sites import EXCLUDED, draw, gateware_files, sites_of
from tools.mutation.workshop import Workshop, equal_circuits, slow_suite, suites


pytestmark = pytest.mark.ci


ROOT = Path(__file__).resolve().parents[3]


def alterations_of(folder, text):
    """Return the alterations of a file with this text."""
    (folder / "hdl").mkdir(exist_ok=True)
    (folder / "hdl" / "unit.py").write_text(textwrap.dedent(text))
    return [one for site in sites_of(folder, "hdl/unit.py") for one in site.alterations]


def changes(folder, text):
    """Return the pairs of old and new text of every alteration."""
    return [(one.old, one.new) for one in alterations_of(folder, text)]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("x = a < b", [("a < b", "((a) <= (b))"), ("a < b", "((a) >= (b))")]),
        ("x = a == b", [("a == b", "((a) != (b))")]),
        ("x = (a + b) * c", [("(a + b) * c", "((a + b) + (c))"), ("a + b", "((a) - (b))")]),
        ("x = a ^ b", [("a ^ b", "((a) & (b))"), ("a ^ b", "((a) | (b))")]),
        ("x = ~a", [("~a", "(a)")]),
        ("x = a and b", [("a and b", "((a) or (b))")]),
        ("x = 7", [("7", "8"), ("7", "(6)")]),
        ("with m.If(a):\n    pass", [("a", "1"), ("a", "((a) == 0)")]),
        # An altered comparison inverts this condition already.
        ("with m.Elif(a == b):\n    pass", [("a == b", "1"), ("a == b", "((a) != (b))")]),
        ("x = Mux(a, b, c)", [("a", "((a) == 0)")]),
        ("x = b if a else c", [("a", "(not (a))")]),
    ],
)
def test_alterations(tmp_path, text, expected):
    assert changes(tmp_path, text) == expected


def test_what_makes_no_circuit_is_left_alone(tmp_path):
    text = '''
    """Text with 1 + 1."""
    x: list[1] = None
    m.d.comb += y
    assert a < 3
    def f(a: 2 = None) -> 3:
        raise ValueError(f"must be {4 + 4}, not {a!r}")
    '''
    assert changes(tmp_path, text) == []


def test_checks_of_arguments_are_marked(tmp_path):
    text = """
    if a < 1:
        raise ValueError
    x = a - b
    """
    marks = {one.old: one.guard for one in alterations_of(tmp_path, text)}
    assert marks == {"a < 1": True, "1": True, "a - b": False}


@pytest.fixture(scope="module")
def sites():
    return [site for file in gateware_files(ROOT) for site in sites_of(ROOT, file)]


def test_alterations_of_the_gateware_are_python(sites):
    files = gateware_files(ROOT)
    assert len(files) > 60
    assert not EXCLUDED & set(files)
    assert all((ROOT / name).is_file() for name in EXCLUDED)
    for alteration in draw(sites, 1, 200):
        source = (ROOT / alteration.file).read_bytes()
        altered = alteration.apply(source)
        assert altered != source
        ast.parse(altered)


def test_the_draw_is_uniform_and_repeatable(sites):
    assert draw(sites, 2026, 50) == draw(sites, 2026, 200)[:50]
    assert draw(sites, 2026, 50) != draw(sites, 2027, 50)
    few = sites[:20]
    place = {one.key: number for number, site in enumerate(few) for one in site.alterations}
    drawn = collections.Counter(
        place[one.key] for seed in range(2_000) for one in draw(few, seed, 5)
    )
    # 500 each, with a standard deviation of 19.
    assert all(400 < drawn[number] < 600 for number in range(20))
    with pytest.raises(ValueError, match=r"^Count must be at most the 20 sites, not 21$"):
        draw(few, 1, 21)


def test_the_draw_stays_while_other_lines_change(tmp_path):
    lines = [f"x_{number} = a_{number} + {number}" for number in range(60)]
    alterations_of(tmp_path, "\n".join(lines))
    before = draw(sites_of(tmp_path, "hdl/unit.py"), 1, 60)
    moved = ["if b:", *(f"    {line}" for line in lines), "y = c - 1"]
    alterations_of(tmp_path, "\n".join(moved))
    after = draw(sites_of(tmp_path, "hdl/unit.py"), 1, 60)
    assert len({one.key for one in before}) == 60
    assert len({one.key for one in before} & {one.key for one in after}) >= 57


def test_the_nearest_tests_come_first():
    near, package, rest = suites(ROOT, "hdl/ga_core/crossover.py")
    assert near[0] == "tests/unit/ga_core/test_crossover.py"
    assert "tests/unit/ga_core/test_read_ports.py" in package
    assert "tests/unit/link/test_cobs.py" in rest
    assert "tests/golden/test_golden.py" in rest
    everything = near + package + rest
    assert len(everything) == len(set(everything))
    assert all((ROOT / name).is_file() for name in everything + slow_suite(ROOT))


#: A miniature project: a unit, a test that covers half of it, and a test that covers nothing.
UNIT = """
def seen(a):
    return a + 1

def unseen(a):
    return a * 2
"""
TEST = """
from pathgene.hdl.unit import seen, unseen

def test_seen():
    assert seen(3) == 4

def test_nothing():
    assert callable(unseen)
"""


@pytest.fixture
def project(tmp_path):
    root = tmp_path / "project"
    (root / "hdl").mkdir(parents=True)
    (root / "pathgene").mkdir()
    (root / "pathgene" / "__init__.py").touch()
    (root / "pathgene" / "hdl").symlink_to("../hdl")
    (root / "tests" / "unit").mkdir(parents=True)
    (root / "pyproject.toml").write_text(
        '[tool.pytest.ini_options]\naddopts = ["--import-mode=importlib"]\npythonpath = ["."]\n'
    )
    (root / "hdl" / "unit.py").write_text(UNIT)
    (root / "tests" / "unit" / "test_unit.py").write_text(TEST)
    (root / "tools").symlink_to(ROOT / "tools")
    return root


def alteration_to(root, new):
    (found,) = [
        one for site in sites_of(root, "hdl/unit.py") for one in site.alterations if one.new == new
    ]
    return found


def test_what_a_test_sees_is_killed_and_taken_back(project, tmp_path):
    shop = Workshop(project, tmp_path / "shop", depth="near")
    result = shop.judge(alteration_to(project, "((a) - (1))"))
    assert (result.verdict, result.by) == ("killed", "tests/unit/test_unit.py::test_seen")
    assert (shop.folder / "hdl" / "unit.py").read_text() == UNIT
    assert shop.failures(["tests/unit/test_unit.py"]) == []


def test_a_test_that_hangs_is_ended(project, tmp_path):
    hanging = TEST + "\n\ndef test_hangs():\n    while True:\n        pass\n"
    (project / "tests" / "unit" / "test_unit.py").write_text(hanging)
    shop = Workshop(project, tmp_path / "shop", limit_s=0.5, depth="near")
    assert shop.failures(["tests/unit/test_unit.py"]) == ["tests/unit/test_unit.py::test_hangs"]


@pytest.mark.parametrize(
    ("new", "verdict", "by"),
    [
        ("(a + a)", "equivalent", "the same RTLIL of every top"),
        ("(a * 2 + 16)", "equivalent", "the same netlist of every top"),
        ("(a - 1)", "survived", "small"),
    ],
    ids=["same", "other text", "other circuit"],
)
def test_what_no_test_sees_is_compared_by_its_circuit(project, tmp_path, new, verdict, by):
    """The tops of the miniature project are lines of text that the unit computes."""
    (project / "tools").unlink()
    (project / "tools" / "mutation").mkdir(parents=True)
    (project / "tools" / "__init__.py").touch()
    (project / "tools" / "mutation" / "__init__.py").touch()
    shutil.copy(ROOT / "tools" / "mutation" / "limit.py", project / "tools" / "mutation")
    (project / "tools" / "mutation" / "tops.py").write_text(
        "import pathlib, sys\n"
        "from pathgene.hdl.unit import unseen\n"
        "stem = pathlib.Path(sys.argv[2], sys.argv[1])\n"
        "stem.with_suffix('.il').write_text(str(unseen(5)))\n"
        "text = f'module chip(output [3:0] q); assign q = {unseen(5) & 15}; endmodule'\n"
        "stem.with_suffix('.v').write_text(text)\n"
    )
    old = alteration_to(project, "((a) + (2))")
    alteration = dataclasses.replace(old, new=new)
    result = Workshop(project, tmp_path / "shop", depth="units").judge(alteration)
    assert (result.verdict, result.by) == (verdict, by)


def entry(verdict, depth="chips", file="hdl/unit.py"):
    alteration = {"file": file, "line": 3, "column": 1, "kind": "unary", "old": "a", "new": "b"}
    alteration |= {"start": 0, "stop": 1, "guard": False, "site": "s"}
    return {
        "key": verdict,
        "verdict": verdict,
        "depth": depth,
        "by": "x",
        "alteration": alteration,
        "state": "1",
    }


def test_report():
    entries = [entry("killed")] * 3 + [entry("equivalent"), entry("survived")]
    assert report(entries).splitlines() == [
        "5 alterations: 3 killed, 1 equivalent, 1 survived; "
        "75.0 % of those that change something are killed",
        "equivalent: hdl/unit.py:3:1 unary: a -> b (x)",
        "survived: hdl/unit.py:3:1 unary: a -> b (x)",
    ]


def test_results_are_kept(tmp_path):
    store = tmp_path / "results.jsonl"
    assert read(store) == {}
    store.write_text(json.dumps(entry("killed")) + "\n" + json.dumps(entry("survived"))[:20])
    assert read(store) == {"killed": entry("killed")}


def test_a_kill_counts_as_long_as_its_test_is_there(project):
    def by(name, verdict="killed"):
        return {**entry(verdict), "by": name}

    assert has_killer(project, by("tests/unit/test_unit.py::test_seen[1-a]"))
    assert has_killer(project, by("tests/unit/test_unit.py"))
    assert has_killer(project, by("limit of time reached"))
    assert has_killer(project, by("", "survived"))
    assert not has_killer(project, by("tests/unit/test_unit.py::test_see"))
    assert not has_killer(project, by("tests/unit/test_gone.py::test_seen"))


def test_only_survivors_are_followed_further():
    assert not is_settled(None, "near", "1")
    assert is_settled(entry("killed", "near"), "chips", "2")
    assert is_settled(entry("survived", "chips"), "near", "1")
    assert is_settled(entry("equivalent", "units"), "chips", "1")
    assert not is_settled(entry("survived", "near"), "units", "1")
    # New tests may notice it, and in other gateware it may matter.
    assert not is_settled(entry("survived", "chips"), "near", "2")
    assert not is_settled(entry("equivalent", "units"), "chips", "2")


REGISTER = """
module top(input clk, input d, output q);
  reg [1:0] kept = 2'd{init};
  always @(posedge clk) kept <= {value};
  assign q = kept[0];
endmodule
"""


@pytest.mark.parametrize(
    ("init", "value", "same"),
    [(0, "{1'b0, ~d}", True), (0, "{1'b0, d}", False), (1, "~d", False)],
    ids=["wide", "inverted", "initial-value"],
)
def test_circuits_are_compared_after_optimization(tmp_path, init, value, same):
    narrow = REGISTER.replace("[1:0] ", "").replace("2'd{init}", "1'd0").replace("kept[0]", "kept")
    (tmp_path / "old.v").write_text(narrow.replace("{value}", "~d"))
    new = REGISTER.replace("{init}", str(init)).replace("{value}", value)
    (tmp_path / "new.v").write_text(new)
    assert equal_circuits(tmp_path / "old.v", tmp_path / "new.v", "top") == same


def test_the_list_names_what_would_be_altered(capsys):
    assert main(["--list", "--count", "3", "--files", "hdl/ga_core/crossover.py"]) == 0
    head, *lines = capsys.readouterr().out.splitlines()
    assert head.startswith("3 of ")
    assert len(lines) == 3
    assert all(line.startswith("hdl/ga_core/crossover.py:") for line in lines)


@pytest.mark.parametrize("count", ["0", "100000"])
def test_refuses_a_count_that_cannot_be_drawn(count, capsys):
    with pytest.raises(SystemExit, match=r"^2$"):
        main(["--list", "--count", count, "--files", "hdl/ga_core/crossover.py"])
    assert "--count must be from 1 to " in capsys.readouterr().err


@pytest.mark.long  # A minute; all of the 200 take hours: ``tests/long/test_mutation_long.py``.
def test_a_sample_is_killed():
    """The sample is the first of the 200 alterations whose result CONTRIBUTING gives."""
    arguments = ["--seed", "2026", "--count", "6", "--depth", "near", "--require", "100"]
    assert main(arguments) == 0
