"""Decisions of a module, and its syntax tree with calls that record their vectors."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import dataclass


__all__ = ["BEGIN", "END", "NOTE", "ONE", "PICK", "Decision", "instrument"]

#: Names of the recorder's functions in an instrumented module.
BEGIN, NOTE, END, PICK, ONE = "__begin__", "__note__", "__end__", "__pick__", "__one__"


@dataclass(frozen=True)
class Decision:
    """A decision of a function.

    Parameters
    ----------
    key : str
        ``module:line:column`` of its first character, unique.
    function : str
        Qualified name of the function.
    conditions : tuple of str
        Source of each condition, from left to right.
    """

    key: str
    line: int
    function: str
    conditions: tuple[str, ...]


def instrument(module: str, source: str) -> tuple[ast.Module, list[Decision]]:
    """Return the syntax tree of a module that records its decisions, and these decisions."""
    tree = ast.parse(source)
    instrumenter = _Instrumenter(module)
    instrumenter.visit(tree)
    return ast.fix_missing_locations(tree), instrumenter.decisions


class _Instrumenter(ast.NodeTransformer):
    """Wraps decisions in calls of the recorder.

    A decision of one condition becomes ``__one__(key, condition)``. A decision of several becomes
    ``__end__(key, vector := __begin__(n), decision)``, in which each condition is
    ``__note__(vector, i, condition)``. ``__pick__`` takes the place of ``__end__`` if the decision
    is a value rather than a test.
    """

    def __init__(self, module: str) -> None:
        self.decisions: list[Decision] = []
        self._module = module
        self._scopes: list[str] = []
        self._functions = 0
        self._iterables = 0

    def _scoped(self, node: ast.AST, name: str, functions: int) -> ast.AST:
        self._scopes.append(name)
        self._functions += functions
        self.generic_visit(node)
        self._functions -= functions
        self._scopes.pop()
        return node

    def visit_ClassDef(self, node: ast.ClassDef) -> ast.AST:
        return self._scoped(node, node.name, 0)

    def visit_FunctionDef(self, node: ast.FunctionDef) -> ast.AST:
        return self._scoped(node, node.name, 1)

    def visit_AsyncFunctionDef(self, node: ast.AsyncFunctionDef) -> ast.AST:
        return self._scoped(node, node.name, 1)

    def visit_AnnAssign(self, node: ast.AnnAssign) -> ast.AST:
        if node.value is not None:
            node.value = self.visit(node.value)
        return node

    def visit_arg(self, node: ast.arg) -> ast.AST:
        return node

    def visit_Assert(self, node: ast.Assert) -> ast.AST:
        return node

    def visit_comprehension(self, node: ast.comprehension) -> ast.AST:
        node.target = self.visit(node.target)
        self._iterables += 1
        node.iter = self.visit(node.iter)
        self._iterables -= 1
        node.ifs = [self._decide(test, END) for test in node.ifs]
        return node

    def _visit_test(self, node: ast.If | ast.While | ast.IfExp) -> ast.AST:
        test = self._decide(node.test, END)
        node.test = ast.Constant(True)
        self.generic_visit(node)
        node.test = test
        return node

    visit_If = visit_While = visit_IfExp = _visit_test

    def visit_match_case(self, node: ast.match_case) -> ast.AST:
        guard = None if node.guard is None else self._decide(node.guard, END)
        node.guard = None
        self.generic_visit(node)
        node.guard = guard
        return node

    def visit_BoolOp(self, node: ast.BoolOp) -> ast.AST:
        return self._decide(node, PICK)

    def visit_Compare(self, node: ast.Compare) -> ast.AST:
        return self._decide(node, PICK)

    def visit_UnaryOp(self, node: ast.UnaryOp) -> ast.AST:
        return (
            self._decide(node, PICK) if isinstance(node.op, ast.Not) else self.generic_visit(node)
        )

    def visit_BinOp(self, node: ast.BinOp) -> ast.AST:
        return self._decide(node, PICK) if _joins_truths(node) else self.generic_visit(node)

    def _decide(self, node: ast.expr, end: str) -> ast.expr:
        """Return a decision that is recorded; the decisions inside its conditions are, too."""
        if self._functions == 0 or isinstance(node, ast.Constant):
            self.generic_visit(node)
            return node
        number = len(self.decisions)
        decision = Decision(
            f"{self._module}:{node.lineno}:{node.col_offset}",
            node.lineno,
            ".".join(self._scopes),
            tuple(_conditions(node)),
        )
        self.decisions.append(decision)
        key = ast.Constant(decision.key)
        if len(decision.conditions) == 1:
            return _at(node, self._only(node, key))
        vector = f"__vector_{number}__"
        recorded = self._recorded(node, vector, iter(range(len(decision.conditions))))
        begun = _call(BEGIN, ast.Constant(len(decision.conditions)))
        if not self._iterables:
            named = ast.NamedExpr(ast.Name(vector, ast.Store()), begun)
            return _at(node, _call(end, key, named, recorded))
        # An iterable of a comprehension must not name a value.
        vector_in = ast.arguments([], [ast.arg(vector)], None, [], [], None, [])
        ended = _call(end, key, ast.Name(vector, ast.Load()), recorded)
        return _at(node, ast.Call(ast.Lambda(vector_in, ended), [begun], []))

    def _only(self, node: ast.expr, key: ast.Constant) -> ast.expr:
        if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
            return ast.UnaryOp(ast.Not(), self._only(node.operand, key))
        return _call(ONE, key, self._leaf(node))

    def _leaf(self, node: ast.expr) -> ast.expr:
        """Return a condition whose inner decisions are recorded."""
        if isinstance(node, ast.Compare):
            self.generic_visit(node)
            return node
        visited: ast.expr = self.visit(node)
        return visited

    def _recorded(self, node: ast.expr, vector: str, numbers: Iterator[int]) -> ast.expr:
        """Return an expression of the same value whose conditions are noted."""
        if isinstance(node, ast.BoolOp):
            node.values = [self._recorded(value, vector, numbers) for value in node.values]
            return node
        if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
            node.operand = self._recorded(node.operand, vector, numbers)
            return node
        if _joins_truths(node):
            assert isinstance(node, ast.BinOp)
            node.left = self._recorded(node.left, vector, numbers)
            node.right = self._recorded(node.right, vector, numbers)
            return node
        if isinstance(node, ast.Compare) and len(node.ops) > 1:
            return self._chain(node, vector, numbers)
        number = ast.Constant(next(numbers))
        noted = _call(NOTE, ast.Name(vector, ast.Load()), number, self._leaf(node))
        return _at(node, noted)

    def _chain(self, node: ast.Compare, vector: str, numbers: Iterator[int]) -> ast.expr:
        """Return ``a < b < c`` as ``a < (between := b) and between < c``, each link noted."""
        if self._iterables:
            # Python forbids an assignment there; no measured module has such a chain.
            raise NotImplementedError(f"{self._module}:{node.lineno}: a chain in an iterable")
        links: list[ast.expr] = []
        left: ast.expr = self.visit(node.left)
        for i, (op, right) in enumerate(zip(node.ops, node.comparators, strict=True)):
            number, right = next(numbers), self.visit(right)
            name = f"{vector}{number}"
            if i < len(node.ops) - 1:
                right = ast.NamedExpr(ast.Name(name, ast.Store()), right)
            link = _at(node, ast.Compare(left, [op], [right]))
            links.append(_call(NOTE, ast.Name(vector, ast.Load()), ast.Constant(number), link))
            left = ast.Name(name, ast.Load())
        return _at(node, ast.BoolOp(ast.And(), links))


def _joins_truths(node: ast.expr) -> bool:
    """Return whether an expression is ``&`` or ``|`` between comparisons."""
    if not (isinstance(node, ast.BinOp) and isinstance(node.op, ast.BitAnd | ast.BitOr)):
        return False
    return all(
        isinstance(side, ast.Compare) or _joins_truths(side) for side in (node.left, node.right)
    )


def _conditions(node: ast.expr) -> list[str]:
    """Return the source of each condition of a decision."""
    if isinstance(node, ast.BoolOp):
        return [each for value in node.values for each in _conditions(value)]
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
        return _conditions(node.operand)
    if _joins_truths(node):
        assert isinstance(node, ast.BinOp)
        return _conditions(node.left) + _conditions(node.right)
    if isinstance(node, ast.Compare) and len(node.ops) > 1:
        operands = [node.left, *node.comparators]
        return [
            ast.unparse(ast.Compare(operands[i], [op], [operands[i + 1]]))
            for i, op in enumerate(node.ops)
        ]
    return [ast.unparse(node)]


def _call(name: str, *arguments: ast.expr) -> ast.Call:
    return ast.Call(ast.Name(name, ast.Load()), list(arguments), [])


def _at(place: ast.AST, node: ast.expr) -> ast.expr:
    """Return a new node at the place of another, and all of its new parts with it."""
    ast.copy_location(node, place)
    return node
