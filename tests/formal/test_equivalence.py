"""Netlists of units are their Verilog, and a changed netlist is noticed."""

import copy
from types import SimpleNamespace

import pytest

from pathgene.hdl.boards.ecp5_cells import Ecp5Cells
from tests.formal.netlists import QUICK, rows_of_the_page
from tools.equivalence import (
    Result,
    as_module,
    check,
    compared,
    main,
    rows,
    rows_of_page,
    synthesized,
    table,
    units,
    with_fault,
)


# A unit of registers and one of arithmetic; RunLimits is compared below, too.
CI = "SkidBuffer", "PathReducer"


def both(name):
    """Return the Verilog of a unit that Yosys decides as it is, and its netlist."""
    make = units()[name]
    built = as_module(make(), SimpleNamespace(cells=Ecp5Cells()))
    return as_module(make()), synthesized(built)


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=pytest.mark.ci if name in CI else pytest.mark.long)
        for name in QUICK
    ],
)
def test_a_netlist_is_its_unit(name):
    assert check(units()[name]).verdict == "equal"


@pytest.mark.parametrize(
    "every",
    [pytest.param(16, marks=pytest.mark.ci), pytest.param(4, marks=pytest.mark.long)],
)
def test_a_changed_table_is_noticed(every):
    verilog, netlist = both("SkidBuffer")
    tables = sum(cell["type"] == "LUT4" for cell in netlist["modules"]["unit"]["cells"].values())
    assert compared(verilog, netlist) == "equal"
    assert tables > 10
    for number in range(0, tables, every):
        assert compared(verilog, with_fault(netlist, number)) == "different", number


@pytest.mark.ci
def test_a_changed_start_is_noticed():
    """The start of a register is noticed if an output shows it: `words.ready` is a register."""
    verilog, netlist = both("SkidBuffer")
    for name, verdict in (("words__ready", "different"), ("kept.last", "equal")):
        changed = copy.deepcopy(netlist)
        parameters = changed["modules"]["unit"]["cells"][f"{name}_TRELLIS_FF_Q"]["parameters"]
        parameters["REGSET"] = {"SET": "RESET", "RESET": "SET"}[parameters["REGSET"]]
        assert compared(verilog, changed) == verdict, name


@pytest.mark.parametrize(
    "pins",
    [
        pytest.param({}, marks=pytest.mark.ci, id="edge"),
        pytest.param({"CLK": "DI"}, marks=pytest.mark.long, id="clock"),
    ],
)
def test_a_changed_clock_is_noticed(pins):
    verilog, netlist = both("SkidBuffer")
    cell = netlist["modules"]["unit"]["cells"]["kept.last_TRELLIS_FF_Q"]
    cell["connections"] |= {pin: cell["connections"][source] for pin, source in pins.items()}
    if not pins:
        cell["parameters"]["CLKMUX"] = "INV"
    assert compared(verilog, netlist) == "different"


@pytest.mark.ci
def test_a_lost_carry_is_noticed():
    """The carry in of a chain of Yosys's own map is left to the device."""
    verilog, netlist = both("RunLimits")
    assert compared(verilog, netlist) == "equal"
    chains = [
        cell["connections"]
        for cell in netlist["modules"]["unit"]["cells"].values()
        if cell["type"] == "CCU2C" and isinstance(cell["connections"]["CIN"][0], int)
    ]
    chains[0]["CIN"] = ["x"]
    assert compared(verilog, netlist) == "different"


def test_an_undecided_row_has_a_reason():
    for name, _, _, verdict, by, _ in rows_of_the_page().values():
        assert verdict in ("equal", "undecided"), name
        assert by or verdict == "equal", name


@pytest.mark.long
@pytest.mark.parametrize("name", rows_of_the_page())
def test_the_page_is_true(name):
    if rows_of_the_page()[name][3] == "equal":
        assert check(units()[name]).verdict == "equal"


def test_a_row_names_the_reason():
    result = Result({"LUT4": 3}, "undecided", "no answer in 60 s", 61.2)
    row = ("Sorter", "3", "0", "undecided", "no answer in 60 s", "61")
    assert rows({"Sorter": result}) == {"Sorter": row}
    text = f"<!-- equivalence -->\n\n{table({'Sorter': row})}\n<!-- end of equivalence -->"
    assert rows_of_page(text) == {"Sorter": row}


def test_an_unknown_unit_is_named(capsys):
    assert main(["--unit", "everything"]) == 2
    assert "No unit 'everything'; choose from " in capsys.readouterr().err
