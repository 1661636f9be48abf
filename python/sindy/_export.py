"""Models as functions of Python and expressions of SymPy."""

from __future__ import annotations

import ast
import re
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from . import _native
from ._errors import fault

# A quoted name, a name, a number, or one other character: the language of the library's expressions.
_TOKEN = re.compile(r'"(?:[^"]|"")*"|[^\W\d][\w.]*|\d+\.?\d*(?:[eE][+-]?\d+)?|\.\d+(?:[eE][+-]?\d+)?|\s+|.')
# Names of functions of one argument here and in NumPy.
_UNARY = {
    "sqrt": "sqrt", "exp": "exp", "log": "log", "sin": "sin", "cos": "cos", "tan": "tan", "asin": "arcsin",
    "acos": "arccos", "atan": "arctan", "tanh": "tanh", "abs": "abs", "sign": "sign", "floor": "floor", "isnan": "isnan",
}  # fmt: skip
_BINARY = {"min": "minimum", "max": "maximum", "hypot": "hypot", "atan2": "arctan2", "if": "where"}
_CONSTANTS = ("pi", "inf", "nan")
_WORDS = ("and", "or", "not")


class _Logic(ast.NodeTransformer):
    """`a and b` of arrays, which Python cannot say."""

    def visit_BoolOp(self, node: ast.BoolOp) -> ast.AST:
        self.generic_visit(node)
        name = "logical_and" if isinstance(node.op, ast.And) else "logical_or"
        out = node.values[0]
        for value in node.values[1:]:
            out = ast.Call(ast.Name(name, ast.Load()), [out, value], [])
        return out

    def visit_UnaryOp(self, node: ast.UnaryOp) -> ast.AST:
        self.generic_visit(node)
        if isinstance(node.op, ast.Not):
            return ast.Call(ast.Name("logical_not", ast.Load()), [node.operand], [])
        return node


def _python(text: str, names: Sequence[str]) -> ast.expr:
    """An expression of the library as one of Python, over `v0`, `v1`, … for the variables."""
    place = {name: f"v{k}" for k, name in enumerate(names)}
    out: list[str] = []
    for token in _TOKEN.findall(text):
        name = token[1:-1].replace('""', '"') if token.startswith('"') else token
        if token.startswith('"') or (name in place and name not in _CONSTANTS):
            out.append(place[name])
        elif name in _UNARY or name in _BINARY:
            out.append(f"f_{name}")
        elif name == "^":
            out.append("**")
        else:
            out.append(f" {token} " if token in _WORDS else token)
    tree = _Logic().visit(ast.parse("".join(out), mode="eval"))
    body: ast.expr = ast.fix_missing_locations(tree).body
    return body


def to_callable(model: _native.Model, xp: Any = np) -> Callable[..., Any]:
    """The right-hand side as a function ``f(t, x, u=())`` of an array module."""
    names = [*model.states, *model.inputs]
    states = len(model.states)
    scope: dict[str, Any] = {"f_" + k: getattr(xp, v) for k, v in {**_UNARY, **_BINARY}.items()}
    scope |= {name: getattr(xp, name) for name in (*_CONSTANTS, "logical_and", "logical_or", "logical_not")}
    sums = []
    for terms in model.terms:
        texts = [f"({c!r})*({ast.unparse(_python(text, names))})" for text, c, _, _ in terms]
        sums.append(" + ".join(texts) or "0.0")
    arguments = ", ".join(f"v{k}" for k in range(len(names)))
    code = compile(f"lambda {arguments}: [{', '.join(sums)}]", "<sindy model>", "eval")
    right = eval(code, scope)  # noqa: S307 (built from parsed expressions of the model)

    def rhs(t: Any, x: Any, u: Any = ()) -> Any:
        if len(x) != states or len(u) != len(names) - states:
            raise fault("x, u", f"{states} states and {len(names) - states} inputs", f"{len(x)} and {len(u)}")
        zero = 0.0 * x[0] if np.ndim(x[0]) == 0 else xp.zeros_like(x[0])
        return xp.stack([xp.asarray(value + zero) for value in right(*x, *u)])

    return rhs


def to_sympy(model: _native.Model) -> list[Any]:
    """One SymPy expression for each state, over symbols with the names of states and inputs."""
    import sympy

    names = [*model.states, *model.inputs]
    scope: dict[str, Any] = {"f_" + name: getattr(sympy, name) for name in _UNARY if hasattr(sympy, name)}
    scope |= {
        "f_abs": sympy.Abs,
        "f_min": sympy.Min,
        "f_max": sympy.Max,
        "f_hypot": lambda a, b: sympy.sqrt(a**2 + b**2),
        "f_atan2": sympy.atan2,
        "pi": sympy.pi,
        "inf": sympy.oo,
        "nan": sympy.nan,
    }
    scope |= {f"v{k}": sympy.Symbol(name, real=True) for k, name in enumerate(names)}
    out = []
    for terms in model.terms:
        total = sympy.Integer(0)
        for text, coefficient, _, _ in terms:
            try:
                code = compile(ast.Expression(_python(text, names)), "<sindy model>", "eval")
                total += sympy.Float(coefficient, 17) * eval(code, scope)  # noqa: S307
            except (NameError, TypeError):
                raise fault("to_sympy", "terms without logic, floor and isnan", text) from None
        out.append(total)
    return out
