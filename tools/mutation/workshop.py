"""A copy of the project in which alterations are tried one after another."""

from __future__ import annotations

import ast
import hashlib
import os
import re
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from tools.mutation.sites import Alteration
from tools.netlist import Netlist


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


#: Removes logic that no output depends on, such as the constant bit of a register that is too wide.
#: Words are split into bits, so that the place of a bit in its word does not count.
_PASSES = "opt -full; wreduce; opt -full; simplemap; opt -full; opt_clean -purge"


class OptimizedNetlist(Netlist):
    """Netlist in which initial values only count for registers, and once each.

    Optimization leaves several names for the same wire, including constants, in an arbitrary order.
    """

    def __init__(self, module: dict[str, Any], *, port_names: bool = True) -> None:
        nets = {}
        seen = set()
        for name, net in module["netnames"].items():
            attributes = dict(net["attributes"])
            init = reversed(attributes.pop("init", ""))
            nets[name] = {"bits": net["bits"], "attributes": attributes}
            for bit, value in zip(net["bits"], init, strict=False):
                if isinstance(bit, int) and value in "01" and bit not in seen:
                    seen.add(bit)
                    nets[f"{name} {bit}"] = {"bits": [bit], "attributes": {"init": value}}
        super().__init__({**module, "netnames": nets}, port_names=port_names)


def equal_circuits(old: Path, new: Path, top: str) -> bool:
    """Return whether two Verilog files are the same circuit after optimization, up to names."""
    first, second = (OptimizedNetlist.read(path, top, passes=_PASSES) for path in (old, new))
    return first.colours == second.colours


_COPIED = (
    "hdl",
    "host",
    "sim",
    "tests",
    "tools",
    "bench",
    "pathgene",
    "docs",
    "examples",
    "constraints",
)
#: Message of the plugin :mod:`tools.mutation.limit`.
_HANGS = "limit of processor time reached"
_OUTCOME = re.compile(r"^(PASSED|FAILED|ERROR) (\S+(?: \S+)*?)(?: - .*)?$", re.MULTILINE)
#: Folders whose effects are not all visible in a netlist, because hosts and models use them as
#: well.
_SHARED = ("hdl/protocol/", "hdl/config.py")


@dataclass(frozen=True)
class Result:
    """Verdict on one alteration."""

    alteration: Alteration
    verdict: str
    #: Test that failed, or the proof that nothing changed.
    by: str
    #: Last stage that the workshop would have tried.
    depth: str
    #: Wall time, including other programs.
    seconds: float

    def as_dict(self) -> dict[str, Any]:
        """Return the entry of the file of results."""
        return {"key": self.alteration.key, **asdict(self)}


@dataclass
class Workshop:
    """A copy of the sources, with separate builds."""

    root: Path
    #: Folder of the copy, which is created.
    folder: Path
    #: Maximum processor time of one test.
    limit_s: float = 60.0
    #: Maximum wall time of one run of pytest.
    wall_s: float = 7200.0
    #: Last stage to try: the tests of its unit and package; the comparison of circuits and the
    #: tests of all units; or simulated chips.
    depth: str = "chips"
    #: Whether the copy begins with the compiled modules and kernels of the original.
    compiled: bool = False
    _circuits: dict[str, dict[str, str]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.folder.mkdir(parents=True)
        ignore = shutil.ignore_patterns("build", *([] if self.compiled else ["__pycache__"]))
        for name in _COPIED:
            if (self.root / name).is_dir():
                shutil.copytree(self.root / name, self.folder / name, ignore=ignore, symlinks=True)
        shutil.copytree(self.root / "hdl", self.folder / "original", ignore=ignore)
        for path in self.root.iterdir():
            if path.is_file() and path.name != ".git":
                shutil.copy2(path, self.folder)
        if (self.root / ".venv").is_dir():
            (self.folder / ".venv").symlink_to(self.root / ".venv")

    # --- One alteration -------------------------------------------------------------------------

    def judge(self, alteration: Alteration) -> Result:
        """Apply an alteration, run the tests, and revert it."""
        start = time.monotonic()
        source = (self.folder / alteration.file).read_bytes()
        with self.altered(alteration.file, alteration.apply(source)):
            verdict, by = self._verdict(alteration)
        return Result(alteration, verdict, by, self.depth, round(time.monotonic() - start, 1))

    def failures(self, tests: Sequence[str], options: Sequence[str] = ()) -> list[str]:
        """Run pytest on some tests; return the failed ones, or a list of files' first failure."""
        return [name for kind, name in self.outcomes(tests, options) if kind != "PASSED"]

    def outcomes(
        self,
        tests: Sequence[str],
        options: Sequence[str] = (),
        variables: Mapping[str, str] | None = None,
    ) -> list[tuple[str, str]]:
        """Run pytest on some tests; return ``FAILED`` or ``ERROR`` and the name of each such test.

        A test that hangs has the kind ``ERROR``.
        Passed tests have the kind ``PASSED`` and are told only if ``options`` ask for them. A run
        that ends in another way has one outcome of the kind ``ERROR``, which says how.
        """
        if not tests:
            return []
        command = [sys.executable, "-m", "pytest", "-q", "--no-header", "--tb=no", "-rfE"]
        command += ["-p", "no:cacheprovider", "-p", "tools.mutation.limit", *options, *tests]
        # A new session, so that the processes of a hanging test end with it.
        with subprocess.Popen(
            command,
            cwd=self.folder,
            env={**self._environment(), **(variables or {})},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            errors="replace",
            start_new_session=True,
        ) as process:
            try:
                printed, _ = process.communicate(timeout=self.wall_s)
            except BaseException as error:
                os.killpg(process.pid, 9)
                if not isinstance(error, subprocess.TimeoutExpired):
                    raise
                return [("ERROR", "limit of time reached")]
        found = [
            ("ERROR" if _HANGS in match[0] else match[1], match[2])
            for match in _OUTCOME.finditer(printed)
        ]
        if process.returncode in (0, 5):
            return found
        return found or [("ERROR", f"pytest ended with status {process.returncode}")]

    def _verdict(self, alteration: Alteration) -> tuple[str, str]:
        nearest, package, rest = suites(self.folder, alteration.file)
        if failed := self.failures([*nearest, *package], ["-x"]):
            return "killed", failed[0]
        if self.depth == "near":
            return "survived", ""
        changed = self._changed("small") or self._changed("large") or self._changed("boards")
        shown = not alteration.guard and not alteration.file.startswith(_SHARED)
        if not changed and shown:
            return "equivalent", "the same RTLIL of every top"
        if changed == ["elaboration"]:
            # A test must report that, not this tool.
            shown = False
        if shown and self._equal_netlists(alteration.file):
            return "equivalent", "the same netlist of every top"
        if failed := self.failures(rest, ["-x"]):
            return "killed", failed[0]
        chips = slow_suite(self.folder) if self.depth == "chips" and changed else ()
        if failed := self.failures(chips, ["-x"]):
            return "killed", failed[0]
        return "survived", ", ".join(changed)

    @contextmanager
    def altered(self, file: str, source: bytes) -> Iterator[None]:
        """Give a file of the copy another text in a block."""
        path = self.folder / file
        original = path.read_bytes()
        build = self.folder / "build"
        before = set(build.glob("*/*"))
        # The compiled file records its source's date in whole seconds, which may not change.
        compiled, aside = path.parent / "__pycache__", path.parent / "__pycache__.aside"
        if compiled.is_dir():
            compiled.rename(aside)
        path.write_bytes(source)
        try:
            yield
        finally:
            path.write_bytes(original)
            shutil.rmtree(compiled, ignore_errors=True)
            if aside.is_dir():
                aside.rename(compiled)
            for entry in set(build.glob("*/*")) - before:
                # Builds of the altered chip are of no further use; object files belong to the
                # simulator.
                if entry.is_dir() and not entry.name.startswith("object-"):
                    shutil.rmtree(entry)

    def _environment(self) -> dict[str, str]:
        return {
            **os.environ,
            "PYTHONPATH": str(self.folder),
            "MUTATION_LIMIT": str(self.limit_s),
            "PYTHONHASHSEED": "0",
            # Messages are cut at the width of the terminal.
            "COLUMNS": "1000",
        }

    # --- Circuits -------------------------------------------------------------------------------

    def _write(self, which: str, name: str, *options: str) -> Path | None:
        folder = self.folder / "circuits" / name
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        status = subprocess.run(
            [sys.executable, "-m", "tools.mutation.tops", which, folder, *options],
            cwd=self.folder,
            env=self._environment(),
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            check=False,
        ).returncode
        return folder if status == 0 else None

    @staticmethod
    def _digests(folder: Path) -> dict[str, str]:
        return {
            path.stem: hashlib.sha256(path.read_bytes()).hexdigest()
            for path in sorted(folder.glob("*.il"))
        }

    def _changed(self, which: str) -> list[str]:
        """Return the top levels of a set whose circuit has changed."""
        original = self._originals(which)
        folder = self._write(which, "altered")
        if folder is None:
            return ["elaboration"]
        digests = self._digests(folder)
        return [name for name, text in original.items() if digests[name] != text]

    def _originals(self, which: str, *options: str) -> dict[str, str]:
        """Return the digests of the unaltered circuits of a set, computed once."""
        name = "-".join(["original", which, *options])
        if name not in self._circuits:
            altered, kept = self.folder / "hdl", self.folder / "hdl.altered"
            altered.rename(kept)
            shutil.copytree(self.folder / "original", altered)
            try:
                folder = self._write(which, name, *options)
            finally:
                shutil.rmtree(altered)
                kept.rename(altered)
            if folder is None:
                raise RuntimeError(f"The unaltered tops of the set {which} do not elaborate")
            self._circuits[name] = self._digests(folder)
        return self._circuits[name]

    def _equal_netlists(self, file: str) -> bool:
        """Return whether an altered ``file`` leaves all top levels unchanged, including boards."""
        cells = file.startswith("hdl/boards/") or file == "hdl/primitives/cells.py"
        for which in ("small", "large", *(["boards"] if cells else [])):
            original = self._originals(which, "verilog")
            folder = self._write(which, "altered", "verilog")
            if folder is None:
                return False
            digests = self._digests(folder)
            for name in (name for name, text in original.items() if digests[name] != text):
                before = self.folder / "circuits" / f"original-{which}-verilog" / f"{name}.v"
                if not equal_circuits(before, folder / f"{name}.v", "chip"):
                    return False
        return True
