"""Netlists of units are their Verilog, and a changed netlist is noticed."""

import copy
from types import SimpleNamespace

import pytest

from pathgene.hdl.boards.ecp5_cells import Ecp5Cells
from pathgene.hdl.verilog import convert
from tests.formal.netlists import QUICK, rows_of_the_page
from tools.equivalence import (
    Result,
    check,
    compared,
    main,
    synthesized,
    table,
    units,
    with_fault,
)


def both(name):
    """Return the Verilog of a unit that Yosys decides as it is, and its netlist."""
    make = units()[name]
    built = convert(make(), "unit", SimpleNamespace(cells=Ecp5Cells()))
    return convert(make(), "unit"), synthesized(built)


@pytest.mark.ci
@pytest.mark.parametrize("name", QUICK)
def test_a_netlist_is_its_unit(name):
    assert check(units()[name]).verdict == "equal"


@pytest.mark.ci
def test_a_changed_table_is_noticed():
    verilog, netlist = both("SkidBuffer")
    tables = sum(cell["type"] == "LUT4" for cell in netlist["modules"]["unit"]["cells"].values())
    assert compared(verilog, netlist) == "equal"
    assert tables > 10
    for number in range(0, tables, 4):
        assert compared(verilog, with_fault(netlist, number)) == "different", number


@pytest.mark.ci
def test_a_changed_start_is_noticed():
    verilog, netlist = both("SkidBuffer")
    cells = netlist["modules"]["unit"]["cells"]
    registers = [name for name, cell in cells.items() if cell["type"] == "TRELLIS_FF"]
    for name in (registers[0], registers[-1]):
        changed = copy.deepcopy(netlist)
        parameters = changed["modules"]["unit"]["cells"][name]["parameters"]
        parameters["REGSET"] = {"SET": "RESET", "RESET": "SET"}[parameters["REGSET"]]
        assert compared(verilog, changed) == "different", name


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


@pytest.mark.long
@pytest.mark.parametrize("name", rows_of_the_page())
def test_the_page_is_true(name):
    expected = rows_of_the_page()[name]
    if expected == "equal":
        assert check(units()[name]).verdict == expected


def test_a_table_names_the_reason():
    result = Result({"LUT4": 3}, "undecided", "no answer in 60 s", 61.2)
    assert table({"Sorter": result}).splitlines()[2].split("|")[1:-1] == [
        " Sorter ",
        " 3    ",
        " 0          ",
        " undecided ",
        " no answer in 60 s ",
        " 61 ",
    ]


def test_an_unknown_unit_is_named(capsys):
    assert main(["--unit", "everything"]) == 2
    assert "No unit 'everything'; choose from " in capsys.readouterr().err
