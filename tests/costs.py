"""What code costs: lines that are no docstring, import, decorator, comment or blank."""

from __future__ import annotations

import ast


def code_lines(source: str) -> int:
    """Code lines of a whole file: those of its classes, its functions beside them and its constants."""
    tree = ast.parse(source)
    lines = source.splitlines()
    left = {number for number, line in enumerate(lines, 1) if line.strip() and not line.strip().startswith("#")}
    for node in ast.walk(tree):
        docstring = isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
        if docstring or isinstance(node, ast.Import | ast.ImportFrom):
            left -= set(range(node.lineno, (node.end_lineno or 0) + 1))
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            left -= {number for each in node.decorator_list for number in range(each.lineno, each.end_lineno + 1)}
    return len(left)
