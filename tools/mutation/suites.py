"""Choice of the tests for a gateware file, nearest and quickest first."""

from __future__ import annotations

import ast
from pathlib import Path


__all__ = ["slow_suite", "suites"]

#: Packages whose tests exercise every file, cheapest first.
_ALL = ("primitives", "protocol", "ga_core", "command", "feasibility", "link", "boards")
#: Simulated whole chips. Tests that themselves alter the gateware's text are left out, because they
#: fail on any change of it.
_SLOW = (
    "tests/cosim/test_cosim.py",
    "tests/cosim/test_boards.py",
    "tests/cosim/test_check_boards.py",
    "tests/cosim/test_parallel_checker.py",
    "tests/cosim/test_checker_terrain.py",
)


def suites(root: Path, file: str) -> list[list[str]]:
    """Return the test files for an altered ``file``: of the unit, of its package, and all.

    Each file is named once. A unit's tests are the mirrored test file and every file that imports
    the unit; the last stage has all unit, model and golden tests that do not need a Verilog
    simulator.
    """
    relative = Path(file).relative_to("hdl")
    unit = root / "tests" / "unit"
    mirrored = unit / relative.with_name(f"test_{relative.name}")
    module = ".".join(("pathgene", *Path(file).with_suffix("").parts))
    package = relative.parts[0] if len(relative.parts) > 1 else ""
    every = [
        path
        for name in dict.fromkeys(filter(None, (package, *_ALL)))
        for path in sorted((unit / name).rglob("test_*.py"))
    ]
    single = sorted(unit.glob("test_*.py"))
    # The golden frames: every message of the protocol as bytes.
    frames = unit / "tools" / "test_protocol_page.py"
    nearest = [mirrored, *([frames] if package == "protocol" else [])]
    nearest += [path for path in (*every, *single) if _imports(path, module)]
    inside = sorted((unit / relative.parent).glob("test_*.py")) if package else []
    inside += [path for path in every if package and (unit / package) in path.parents]
    # Every port, and the layouts that ports share.
    inside.append(unit / "test_documented_ports.py")
    rest = [
        frames,
        *(unit / f"test_{name}.py" for name in ("config", "control", "verilog")),
        *every,
        *sorted((unit / "model").glob("test_*.py")),
        *sorted((unit / "device").glob("test_*.py")),
        *sorted((root / "tests" / "golden").glob("test_*.py")),
    ]
    seen: set[Path] = set()
    stages = []
    for stage in (nearest, inside, rest):
        chosen = [path for path in dict.fromkeys(stage) if path not in seen and path.is_file()]
        seen.update(chosen)
        stages.append([path.relative_to(root).as_posix() for path in chosen])
    return stages


def slow_suite(root: Path) -> list[str]:
    """Return the tests of simulated chips, for an alteration that survives all faster tests."""
    return [name for name in _SLOW if (root / name).is_file()]


def _imports(path: Path, module: str) -> bool:
    for node in ast.walk(ast.parse(path.read_bytes())):
        if isinstance(node, ast.ImportFrom) and node.module == module:
            return True
        if isinstance(node, ast.Import) and any(name.name == module for name in node.names):
            return True
    return False
