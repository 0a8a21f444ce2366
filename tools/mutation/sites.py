"""Sites of the gateware's sources where alterations are possible, with the new texts."""

from __future__ import annotations

import ast
import hashlib
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from pathgene.hdl.boards import BOARDS


#: Files of ``hdl/`` that are not gateware: board tables, build and routing tools, writers of files.
EXCLUDED = frozenset(
    {
        *(f"{module.removeprefix('pathgene.').replace('.', '/')}.py" for module in BOARDS.values()),
        "hdl/boards/__init__.py",
        "hdl/boards/board.py",
        "hdl/boards/build.py",
        "hdl/boards/ecp5.py",
        "hdl/boards/harness.py",
        "hdl/boards/pll.py",
        "hdl/boards/route.py",
        "hdl/boards/tools.py",
        "hdl/verilog.py",
    }
)

_COMPARISONS: dict[type[ast.cmpop], tuple[str, ...]] = {
    ast.Lt: ("<=", ">="),
    ast.LtE: ("<", ">"),
    ast.Gt: (">=", "<="),
    ast.GtE: (">", "<"),
    ast.Eq: ("!=",),
    ast.NotEq: ("==",),
    ast.Is: ("is not",),
    ast.IsNot: ("is",),
    ast.In: ("not in",),
    ast.NotIn: ("in",),
}
_OPERATIONS: dict[type[ast.operator], tuple[str, ...]] = {
    ast.Add: ("-",),
    ast.Sub: ("+",),
    ast.Mult: ("+",),
    ast.FloorDiv: ("*",),
    ast.Div: ("*",),
    ast.Mod: ("//",),
    ast.Pow: ("*",),
    ast.LShift: (">>",),
    ast.RShift: ("<<",),
    ast.BitAnd: ("|",),
    ast.BitOr: ("&",),
    ast.BitXor: ("&", "|"),
}


@dataclass(frozen=True)
class Alteration:
    """One change of one source file."""

    #: Path in the repository, with slashes.
    file: str
    #: Place of the altered expression; both start at 1.
    line: int
    column: int
    kind: str
    old: str
    new: str
    #: Bytes of the file that ``new`` replaces.
    start: int
    stop: int
    #: True if the expression belongs to a check that raises an exception, or does not affect the
    #: netlist.
    guard: bool
    #: Name of the site: its file, the text of its line, and its place in that line. It stays the
    #: same when different lines change.
    site: str

    @property
    def key(self) -> str:
        """Name of the alteration: its site, and the new text."""
        return f"{self.site} -> {self.new}"

    @property
    def place(self) -> str:
        """File, line and column, then the change, for a reader."""
        old, new = (" ".join(text.split()) for text in (self.old, self.new))
        return f"{self.file}:{self.line}:{self.column} {self.kind}: {old} -> {new}"

    def apply(self, source: bytes) -> bytes:
        """Return the altered text of the file."""
        return source[: self.start] + self.new.encode() + source[self.stop :]


@dataclass(frozen=True)
class Site:
    """An operator, constant or condition, with the alterations that it allows."""

    alterations: tuple[Alteration, ...]


def gateware_files(root: Path) -> list[str]:
    """Return the files of the gateware below ``root``, sorted."""
    files = (path.relative_to(root).as_posix() for path in (root / "hdl").rglob("*.py"))
    return sorted(name for name in files if name not in EXCLUDED)


def sites_of(root: Path, file: str) -> list[Site]:
    """Return the sites of one file in the order of its text."""
    source = (root / file).read_bytes()
    finder = _Finder(file, source)
    finder.visit(ast.parse(source))
    return sorted(
        finder.sites, key=lambda site: (site.alterations[0].start, -site.alterations[0].stop)
    )


def draw(sites: Sequence[Site], seed: int, count: int) -> list[Alteration]:
    """Draw ``count`` distinct sites uniformly, and one alteration of each uniformly.

    A larger ``count`` continues the list of a smaller one. The rank of a site in the draw is a hash
    of the seed and of the site's name, so a change of the gateware only affects the draw by the
    sites that it adds or removes.

    Raises
    ------
    ValueError
        If there are fewer sites.
    """
    if count > len(sites):
        raise ValueError(f"Count must be at most the {len(sites)} sites, not {count}")
    drawn = sorted(
        (_hash(seed, site.alterations[0].site), number, site) for number, site in enumerate(sites)
    )[:count]
    return [site.alterations[value % len(site.alterations)] for value, _, site in drawn]


def _hash(seed: int, name: str) -> int:
    return int.from_bytes(hashlib.sha256(f"{seed} {name}".encode()).digest()[:16], "little")


class _Finder(ast.NodeVisitor):
    def __init__(self, file: str, source: bytes) -> None:
        self.file, self.source = file, source
        self.sites: list[Site] = []
        self.guard = False
        self.names: Counter[str] = Counter()
        self.line_starts = [0]
        for line in source.splitlines(keepends=True):
            self.line_starts.append(self.line_starts[-1] + len(line))

    # --- Text -----------------------------------------------------------------------------------

    def span(self, node: ast.expr) -> tuple[int, int]:
        assert node.end_lineno is not None
        assert node.end_col_offset is not None
        return (
            self.line_starts[node.lineno - 1] + node.col_offset,
            self.line_starts[node.end_lineno - 1] + node.end_col_offset,
        )

    def text(self, node: ast.expr) -> str:
        start, stop = self.span(node)
        return self.source[start:stop].decode()

    def name_of(self, node: ast.expr, kind: str) -> str:
        """Name a site by the text of its line, which few other lines of the file repeat."""
        first, last = self.line_starts[node.lineno - 1 : node.lineno + 1]
        line = self.source[first:last].decode()
        indent = len(line) - len(line.lstrip())
        name = f"{self.file}: {line.strip()} @ {node.col_offset - indent} {kind} {self.text(node)}"
        self.names[name] += 1
        return f"{name} #{self.names[name]}"

    def add(self, node: ast.expr, kind: str, texts: Iterator[str] | Sequence[str]) -> None:
        start, stop = self.span(node)
        place = (self.file, node.lineno, node.col_offset + 1, kind, self.text(node))
        site = self.name_of(node, kind)
        found = tuple(Alteration(*place, new, start, stop, self.guard, site) for new in texts)
        if found:
            self.sites.append(Site(found))

    # --- Operators and constants ----------------------------------------------------------------

    def visit_Compare(self, node: ast.Compare) -> None:
        terms = [f"({self.text(term)})" for term in (node.left, *node.comparators)]
        # As in `a not in b`.
        a, b = ast.Name("a"), ast.Name("b")
        symbols = [ast.unparse(ast.Compare(a, [each], [b]))[2:-2] for each in node.ops]
        for place, operator in enumerate(node.ops):
            texts = []
            for symbol in _COMPARISONS[type(operator)]:
                used = [*symbols[:place], symbol, *symbols[place + 1 :]]
                pairs = zip(used, terms[1:], strict=True)
                texts.append(f"({terms[0]} {' '.join(f'{s} {term}' for s, term in pairs)})")
            self.add(node, "comparison", texts)
        self.generic_visit(node)

    def visit_BinOp(self, node: ast.BinOp) -> None:
        left, right = self.text(node.left), self.text(node.right)
        symbols = _OPERATIONS.get(type(node.op), ())
        if not isinstance(node.left, ast.Constant) or isinstance(node.left.value, int):
            self.add(node, "operator", [f"(({left}) {symbol} ({right}))" for symbol in symbols])
        self.generic_visit(node)

    def visit_BoolOp(self, node: ast.BoolOp) -> None:
        symbol = "or" if isinstance(node.op, ast.And) else "and"
        terms = f" {symbol} ".join(f"({self.text(term)})" for term in node.values)
        self.add(node, "logic", [f"({terms})"])
        self.generic_visit(node)

    def visit_UnaryOp(self, node: ast.UnaryOp) -> None:
        if isinstance(node.op, ast.Invert | ast.Not | ast.USub):
            self.add(node, "unary", [f"({self.text(node.operand)})"])
        self.generic_visit(node)

    def visit_Constant(self, node: ast.Constant) -> None:
        if type(node.value) is int:
            self.add(node, "constant", [str(node.value + 1), f"({node.value - 1})"])

    # --- Conditions -----------------------------------------------------------------------------

    def condition(self, node: ast.expr, *, inverted: str, dropped: bool) -> None:
        """Record a condition, without inversions that an altered operator makes as well."""
        texts = ["1"] if dropped else []
        inner = node.operand if isinstance(node, ast.UnaryOp) else node
        simple = isinstance(node, ast.Compare) and len(node.ops) == 1
        if not simple and inner is node:
            texts.append(inverted.format(self.text(node)))
        self.add(node, "condition", texts)

    def visit_Call(self, node: ast.Call) -> None:
        name = node.func.attr if isinstance(node.func, ast.Attribute) else ""
        name = node.func.id if isinstance(node.func, ast.Name) else name
        if name in ("If", "Elif") and len(node.args) == 1:
            self.condition(node.args[0], inverted="(({}) == 0)", dropped=True)
        if name == "Mux":
            self.condition(node.args[0], inverted="(({}) == 0)", dropped=False)
        self.generic_visit(node)

    def visit_If(self, node: ast.If) -> None:
        guard, self.guard = self.guard, self.guard or isinstance(node.body[-1], ast.Raise)
        self.condition(node.test, inverted="(not ({}))", dropped=False)
        self.visit(node.test)
        self.guard = guard
        for statement in (*node.body, *node.orelse):
            self.visit(statement)

    def visit_IfExp(self, node: ast.IfExp) -> None:
        self.condition(node.test, inverted="(not ({}))", dropped=False)
        self.generic_visit(node)

    def visit_comprehension(self, node: ast.comprehension) -> None:
        for test in node.ifs:
            self.condition(test, inverted="(not ({}))", dropped=False)
        self.generic_visit(node)

    # --- No gateware ----------------------------------------------------------------------------

    def visit_AnnAssign(self, node: ast.AnnAssign) -> None:
        if node.value is not None:
            self.visit(node.value)

    def visit_FunctionDef(self, node: ast.FunctionDef) -> None:
        for default in (*node.args.defaults, *filter(None, node.args.kw_defaults)):
            self.visit(default)
        if node.name in ("__repr__", "__str__"):
            return
        for statement in node.body:
            self.visit(statement)

    def visit_AugAssign(self, node: ast.AugAssign) -> None:
        # Amaranth's statement lists grow by `+=`, which is not arithmetic.
        self.visit(node.value)

    def visit_Assert(self, node: ast.Assert) -> None:
        """Skip assertions, which do not become circuits."""

    def visit_Raise(self, node: ast.Raise) -> None:
        """Skip messages, which the tests of the units match as a whole."""

    def visit_JoinedStr(self, node: ast.JoinedStr) -> None:
        """Skip text: names of submodules, and messages."""
