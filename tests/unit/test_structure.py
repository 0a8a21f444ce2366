"""The rules of the source tree: imports, lengths of files, and removed names.

The contracts of the imports are in ``pyproject.toml``, under ``tool.importlinter``.
"""

import ast
import gc
import os
import subprocess
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import grimp
import pytest


ROOT = Path(__file__).resolve().parents[2]
#: Folders with Python files of the project.
FOLDERS = ("hdl", "host", "pathgene", "sim", "bench", "tools", "tests")
#: The packages of the graph of imports; pytest loads tests file by file.
PACKAGES = ("pathgene", "bench", "tools")

MOST_LINES = 450
MOST_LINES_OF_ELABORATE = 150

#: Names that have been replaced, with their successors.
OLD_NAMES = {
    "AltitudeCompare": "AltitudeComparator",
    "BoardCounts": "BoardCollisionCounter",
    "CheckingUnit": "CheckController",
    "Core": "PaperCore",
    "DrawLayout": "RandomWordLayout",
    "FixedFields": "FieldDecoder",
    "GeneticCoreTop": "PaperCoreTop",
    "Mover": "WaypointPerturber",
    "OrderTaker": "RankingParser",
    "Passing": "PositionCounter",
    "Patcher": "TerrainAwareSampler",
    "Ports": "ReadCrossbar",
    "ReadOut": "PathReader",
    "STREAMING": "PLANNER of GeneticCore",
    "SetUp": "SegmentSetup",
    "States": "OneHotSequencer",
    "WaypointWords": "WaypointAssembler",
    "copies": "fanout",
    "genetic": "core of the configuration",
    "memories": "the job of the memories, or block_rams of a device",
    "over": "done, or clear of a path without collision",
    "parallel_core": "paper_core",
    "starts": "start_requests, or launch of a pulse",
    "streaming_core": "planner_core",
    "without_contents": "strip_zero_init",
}


@cache
def sources() -> dict[str, str]:
    """Text of every Python file of the project, by its path."""
    files = [file for folder in FOLDERS for file in sorted((ROOT / folder).rglob("*.py"))]
    return {str(file.relative_to(ROOT)): file.read_text() for file in files}


@cache
def trees() -> dict[str, ast.Module]:
    gc.disable()  # Collecting garbage would visit millions of nodes, and find none.
    parsed = {path: ast.parse(text, path) for path, text in sources().items()}
    gc.enable()
    return parsed


@pytest.fixture(scope="module", autouse=True)
def released() -> Iterator[None]:
    yield
    trees.cache_clear()


def identifiers(tree: ast.AST) -> Iterator[str]:
    """Yield every identifier of a syntax tree; strings and keys do not count."""
    for node in ast.walk(tree):
        match node:
            case ast.Name(id=name) | ast.Attribute(attr=name) | ast.arg(arg=name):
                yield name
            case ast.FunctionDef(name=name) | ast.AsyncFunctionDef(name=name):
                yield name
            case ast.ClassDef(name=name) | ast.MatchAs(name=str(name)):
                yield name
            case ast.keyword(arg=str(name)):
                yield name
            case ast.alias(name=name, asname=other):
                yield from name.split(".")
                yield from [other] if other else []
            case ast.ImportFrom(module=str(name)):
                yield from name.split(".")


def circles(imports: dict[str, set[str]]) -> list[list[str]]:
    """Return the groups of two or more that import each other, directly or not.

    Tarjan's algorithm: the strongly connected components of a graph.
    """
    order: dict[str, int] = {}
    lowest: dict[str, int] = {}
    stack: list[str] = []
    found = []

    def visit(module: str) -> None:
        order[module] = lowest[module] = len(order)
        stack.append(module)
        for imported in sorted(imports[module]):
            if imported not in order:
                visit(imported)
                lowest[module] = min(lowest[module], lowest[imported])
            elif imported in stack:
                lowest[module] = min(lowest[module], order[imported])
        if lowest[module] == order[module]:
            at = stack.index(module)
            group = stack[at:]
            del stack[at:]
            if len(group) > 1:
                found.append(sorted(group))

    for module in sorted(imports):
        if module not in order:
            visit(module)
    return found


# --- Imports -------------------------------------------------------------------------------------


def lint_imports(folder):
    """Run the contracts on the packages next to a ``pyproject.toml``."""
    return subprocess.run(
        [Path(sys.executable).with_name("lint-imports"), "--no-logo", "--no-cache"],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(folder), "NO_COLOR": "1", "COLUMNS": "200"},
        capture_output=True,
        text=True,
        check=False,
    )


def test_imports_keep_the_contracts():
    done = lint_imports(ROOT)
    assert done.returncode == 0, done.stdout + done.stderr
    assert ", 0 broken." in done.stdout


# One import that each contract forbids, and a part of the contract's name.
FORBIDDEN = {
    "Shipped packages import no tests": ("host/cli/terrain.py", "import tools.runner"),
    "Developer tools import no": ("tools/lint.py", "import bench.report"),
    "imports neither host nor simulation": ("hdl/verilog.py", "import pathgene.host.errors"),
    "are pure Python": ("hdl/protocol/codec.py", "import amaranth"),
    "The gateware's layers": ("hdl/primitives/logic.py", "import pathgene.hdl.link.uart"),
    "only configuration and protocol": ("host/cli/plan.py", "import pathgene.hdl.verilog"),
    "The host's layers": ("host/terrain/load.py", "import pathgene.host.problem.problem"),
    "The planners' layers": (
        "host/planners/grid/astar.py",
        "import pathgene.host.planners.chip.schedule",
    ),
    "never by name": ("host/cli/board.py", "import pathgene.sim.cache"),
    "imports the public API": ("sim/cache.py", "from pathgene import Problem"),
    "re-exports the host": ("pathgene/__init__.py", "import pathgene.sim.cache"),
    "imports the gateware alone": ("sim/model/core.py", "import pathgene.host.errors"),
    "The simulation's layers": ("sim/cache.py", "import pathgene.sim.compiler"),
    "shares no code with the host": ("sim/autopilot/airframe.py", "import pathgene.host.numeric"),
    "Errors are a leaf": ("host/errors.py", "import pathgene.hdl.config"),
    "imports in a circle": ("host/report/style.py", "import pathgene.host.report.write"),
}


@pytest.mark.ci
def test_each_contract_notices_a_forbidden_import(tmp_path):
    """The packages have files that contain only imports."""
    (tmp_path / "pyproject.toml").write_text((ROOT / "pyproject.toml").read_text())
    forbidden: dict[str, str] = {}
    for path, line in FORBIDDEN.values():
        forbidden[path] = forbidden.get(path, "") + line + "\n"
    for path, module in trees().items():
        if not path.startswith("tests/"):
            lines = [
                ast.unparse(node)
                for node in ast.walk(module)
                if isinstance(node, ast.Import | ast.ImportFrom)
            ]
            file = tmp_path / path
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text("\n".join([*lines, forbidden.get(path, "")]))
    for folder in ("hdl", "host", "sim"):
        (tmp_path / "pathgene" / folder).symlink_to(f"../{folder}")
    done = lint_imports(tmp_path)
    results = [line for line in done.stdout.splitlines() if " BROKEN" in line or " KEPT" in line]
    assert len(results) == len(FORBIDDEN)
    for contract in FORBIDDEN:
        assert [line for line in results if contract in line and "BROKEN" in line], contract


@cache
def imports() -> dict[str, set[str]]:
    graph = grimp.build_graph(*PACKAGES, cache_dir=None)
    return {module: graph.find_modules_directly_imported_by(module) for module in graph.modules}


def test_no_files_import_each_other():
    """Imports at the top, inside functions and for type checking all count."""
    assert circles(imports()) == []


def test_circles_are_found():
    graph = {"a": {"b"}, "b": {"c", "d"}, "c": {"a"}, "d": set(), "e": {"f"}, "f": {"e", "a"}}
    assert circles(graph) == [["a", "b", "c"], ["e", "f"]]


def test_functions_and_type_checking_count():
    assert "pathgene.hdl.verilog" in imports()["pathgene.sim.exported"]  # Inside a function.
    assert "pathgene.hdl.config" in imports()["pathgene.sim.exported"]  # For type checking.


# --- Sizes ---------------------------------------------------------------------------------------


def test_no_file_is_too_long():
    lengths = {path: text.count("\n") for path, text in sources().items()}
    for folder in (*FOLDERS, "examples"):
        for suffix in ("c", "cpp", "css", "hpp", "html", "js", "v"):
            for path in (ROOT / folder).rglob(f"*.{suffix}"):
                lengths[str(path.relative_to(ROOT))] = path.read_text("utf-8").count("\n")
    assert "examples/client.c" in lengths
    assert {path: length for path, length in lengths.items() if length > MOST_LINES} == {}


@pytest.mark.ci
def test_no_elaborate_is_too_long():
    long = {
        f"{path}:{node.lineno}": node.end_lineno - node.lineno + 1
        for path, tree in trees().items()
        for node in ast.walk(tree)
        if isinstance(node, ast.FunctionDef)
        and node.name == "elaborate"
        and node.end_lineno - node.lineno >= MOST_LINES_OF_ELABORATE
    }
    assert long == {}


# --- Files ---------------------------------------------------------------------------------------

#: Methods of paths that change a disk.
WRITING = {"mkdir", "rename", "rmdir", "symlink_to", "touch", "unlink", "write_bytes", "write_text"}


def writing_calls(tree: ast.Module) -> list[int]:
    """Return the lines that change a disk by a path's method, or open a file for writing."""
    lines = []
    for node in ast.walk(tree):
        match node:
            case ast.Call(func=ast.Attribute(value=ast.Call(func=ast.Name(id="current")))):
                continue  # The disk itself.
            case ast.Call(func=ast.Attribute(attr=name)) if name in WRITING:
                lines.append(node.lineno)
            case ast.Call(
                func=ast.Attribute(attr="open") | ast.Name(id="open"),
                args=[*_, ast.Constant(value=str(mode))],
            ) if set(mode) <= set("rwaxbt+") and set(mode) & set("wax+"):
                lines.append(node.lineno)
    return lines


@pytest.mark.ci
def test_the_host_writes_through_one_disk():
    found = {
        f"{path}:{line}"
        for path, tree in trees().items()
        if path.startswith(("host/", "pathgene/")) and not path.startswith("host/files/")
        for line in writing_calls(tree)
    }
    assert found == set()


def test_calls_that_write_are_found():
    wrong = 'path.write_text("a")\npath.open("xb")\nopen(name, "w")\npath.mkdir()'
    right = 'path.open("rb")\npath.read_text()\nopen(name)\nboard.open("sim:")\nport.open(url)'
    assert writing_calls(ast.parse(wrong)) == [1, 2, 3, 4]
    assert writing_calls(ast.parse(right)) == []


# --- Units ---------------------------------------------------------------------------------------


def components(trees: dict[str, ast.Module]) -> dict[str, tuple[str, ast.ClassDef]]:
    """Return the components of ``hdl/`` by their names, each with its file."""
    return {
        node.name: (path, node)
        for path, tree in trees.items()
        if path.startswith("hdl/")
        for node in ast.walk(tree)
        if isinstance(node, ast.ClassDef)
        and any(ast.unparse(base) == "Unit" for base in node.bases)
    }


def leaves_with_config(trees: dict[str, ast.Module]) -> list[str]:
    """Return the components that take the configuration and do not contain a component."""
    found = components(trees)
    leaves = []
    for name, (path, component) in found.items():
        made = {
            node.func.id
            for node in ast.walk(component)
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name)
        }
        parameters = {
            ast.unparse(statement.target)
            for statement in component.body
            if isinstance(statement, ast.AnnAssign)
        }
        if "config" in parameters and not made & found.keys():
            leaves.append(f"{path}: {name}")
    return sorted(leaves)


def test_no_leaf_takes_the_configuration():
    """A leaf takes the sizes it needs, so it can be reused and is independent of further sizes."""
    assert leaves_with_config(trees()) == []


def test_leaves_with_the_configuration_are_found():
    source = """
class Owner(Unit):
    config: InstanceOf(Config)
    def elaborate(self, platform):
        m = Module()
        m.submodules.leaf = Leaf(self.config)
        return m
class Leaf(Unit):
    config: InstanceOf(Config)
    width: Width(1)
    def interface(self):
        return {"out": Out(self.width)}
class Plain(Unit):
    width: Width(1)
    def interface(self):
        return {"out": Out(self.width)}
class NoUnit:
    config: Config
"""
    assert leaves_with_config({"hdl/a.py": ast.parse(source)}) == ["hdl/a.py: Leaf"]
    assert leaves_with_config({"host/a.py": ast.parse(source)}) == []
    assert len(components(trees())) > 50


# --- Names ---------------------------------------------------------------------------------------


def test_no_identifier_has_an_old_name():
    found = {
        (path, name): OLD_NAMES[name]
        for path, tree in trees().items()
        for name in identifiers(tree)
        if name in OLD_NAMES
    }
    assert found == {}


def hierarchical_lines(texts: dict[str, str]) -> list[str]:
    """Return the lines that name the hierarchical build, which was removed."""
    return [
        f"{path}:{number}"
        for path, text in texts.items()
        for number, line in enumerate(text.splitlines(), 1)
        if "hierarchical" in line.lower()
    ]


def test_nothing_is_hierarchical():
    """No identifier or text does so, in Python, C++ or any other language."""
    texts = {
        str(file.relative_to(ROOT)): file.read_text(errors="replace")
        for folder in ("hdl", "sim", "host")
        for file in (ROOT / folder).rglob("*")
        if file.is_file() and file.suffix != ".pyc"
    }
    assert {"hdl/top.py", "sim/board/bridge.cpp", "host/errors.py"} <= texts.keys()
    assert hierarchical_lines(texts) == []


def test_hierarchical_lines_are_found():
    text = "class HierarchicalWalker:\n    pass  # yosys: hierarchy\nbuild = 'hierarchical'\n"
    assert hierarchical_lines({"a.py": text}) == ["a.py:1", "a.py:3"]


def test_identifiers_of_every_kind_are_found():
    source = """
import a.b as c
from d.e import f
class G:
    h = i.j
async def k(l, *m, n=0, **o):
    return p(q=r, s={"t": "u"})
match v:
    case w: pass
"""
    found = set(identifiers(ast.parse(source)))
    assert found == set("abcdefhijklmnopqrsvwG") - {"t", "u"}


# --- Zones ---------------------------------------------------------------------------------------

#: The file that may ask for the class of a zone.
ZONES = "host/problem/zones.py"
ZONE_CLASSES = {"Circle", "Polygon", "Zone", "Disc", "Area"}


def asked_classes(tree: ast.AST) -> Iterator[tuple[int, str]]:
    """Yield line and name of each class with which code compares an object's class."""
    for node in ast.walk(tree):
        match node:
            case (
                ast.Call(func=ast.Name(id="isinstance" | "issubclass"), args=[_, asked])
                | ast.Compare(left=ast.Call(func=ast.Name(id="type")), comparators=[asked])
                | ast.MatchClass(cls=asked)
            ):
                yield from ((asked.lineno, name) for name in identifiers(asked))


def test_zones_answer_for_themselves():
    """A difference between kinds of zones is a method of their footprint."""
    asking = [
        f"{path}:{line}: {name}"
        for path, tree in trees().items()
        if path != ZONES and not path.startswith("tests/")
        for line, name in asked_classes(tree)
        if name in ZONE_CLASSES
    ]
    assert asking == []


def test_questions_about_classes_are_found():
    code = (
        "isinstance(zone, Circle)\n"
        "isinstance(zone, (int, zones.Polygon))\n"
        "type(zone) is Circle\n"
        "match zone:\n"
        "    case Polygon(ring=r):\n"
        "        Circle(1, 2, 3)\n"
    )
    found = [at for at in asked_classes(ast.parse(code)) if at[1] in ZONE_CLASSES]
    assert found == [(1, "Circle"), (2, "Polygon"), (3, "Circle"), (5, "Polygon")]
