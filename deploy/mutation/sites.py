"""Where a source file can be changed by a plausible mistake, and the text of the change.

A site is an expression or a statement of a function that is not constexpr. Every mutant of a build is compiled in at once, and the environment
variable HAPTON_MUTANT chooses one: `a < b` becomes `(hapton_has_mutant(7) ? (a <= b) : (a < b))`.
"""

from dataclasses import dataclass
from pathlib import Path

from clang import cindex
from clang.cindex import CursorKind, TypeKind

RELATIONS = {"<": ["<=", ">"], "<=": ["<", ">="], ">": [">=", "<"], ">=": [">", "<="], "==": ["!="], "!=": ["=="]}
ARITHMETIC = {"+": ["-"], "-": ["+"], "*": ["/"], "/": ["*"]}
LOGIC = {"&&": ["||"], "||": ["&&"]}
ASSIGNMENTS = {"+=": ["-="], "-=": ["+="], "*=": ["/="], "/=": ["*="]}
OPPOSITES = {"min": "max", "max": "min", "front": "back", "back": "front", "floor": "ceil", "ceil": "floor"}
NUMBERS = (
    TypeKind.BOOL, TypeKind.CHAR_S, TypeKind.SCHAR, TypeKind.UCHAR, TypeKind.SHORT, TypeKind.USHORT, TypeKind.INT, TypeKind.UINT,
    TypeKind.LONG, TypeKind.ULONG, TypeKind.LONGLONG, TypeKind.ULONGLONG, TypeKind.FLOAT, TypeKind.DOUBLE)
COMPARED = NUMBERS + (TypeKind.ENUM, TypeKind.POINTER, TypeKind.NULLPTR)
FUNCTIONS = (
    CursorKind.FUNCTION_DECL, CursorKind.CXX_METHOD, CursorKind.CONSTRUCTOR, CursorKind.DESTRUCTOR, CursorKind.FUNCTION_TEMPLATE,
    CursorKind.CONVERSION_FUNCTION, CursorKind.LAMBDA_EXPR)
# Code that is evaluated at compile time.
SKIPPED = (CursorKind.ENUM_DECL, CursorKind.STATIC_ASSERT, CursorKind.TEMPLATE_TYPE_PARAMETER, CursorKind.TEMPLATE_NON_TYPE_PARAMETER)


@dataclass
class Mutant:
    path: str  # within the source tree
    line: int
    operator: str
    start: int  # offset in the file, in bytes
    end: int
    original: str
    mutated: str
    number: int = 0
    context: str = ""  # if a number was changed: its line

    def code(self) -> str:
        condition = f"hapton_has_mutant({self.number})"
        if self.operator == "statement deleted":
            return f"if (!{condition}) {self.original}"
        if self.operator == "compound assignment":
            return f"if ({condition}) {{ {self.mutated}; }} else {self.original}"
        return f"({condition} ? ({self.mutated}) : ({self.original}))"

    def key(self) -> str:
        """Identifies the mutant, as long as its line of code does not change."""
        suffix = f" in: {self.context}" if self.context else ""
        return f"{self.path}: {self.original} -> {self.mutated or '(deleted)'}{suffix}".replace("\n", " ")

    def describe(self) -> str:
        return f"{self.path}:{self.line}: {self.operator}: {' '.join(self.original.split())} -> {' '.join(self.mutated.split()) or '(deleted)'}"


class SiteFinder:
    """Finds all mutants of one file. The text is kept as bytes, because clang counts positions in bytes."""

    def __init__(self, root: Path, path: str, unit: cindex.TranslationUnit):
        self.path = path
        self.file = str(root / path)
        self.text = (root / path).read_bytes()
        self.mutants: list[Mutant] = []
        self.visit(unit.cursor, False)

    def visit(self, cursor, in_body: bool):
        for child in cursor.get_children():
            if cursor.kind == CursorKind.TRANSLATION_UNIT and (child.location.file is None or child.location.file.name != self.file):
                continue
            if child.kind in SKIPPED or self.is_constant(child):
                continue
            if in_body:
                self.add_sites(child, cursor)
            self.visit(child, in_body or child.kind in FUNCTIONS)

    def source(self, cursor) -> str:
        return self.text[cursor.extent.start.offset:cursor.extent.end.offset].decode(errors="replace")

    def is_constant(self, cursor) -> bool:
        if cursor.kind not in FUNCTIONS and cursor.kind not in (CursorKind.VAR_DECL, CursorKind.FIELD_DECL):
            return False
        head = self.source(cursor).split("{")[0].split("=")[0]
        return "constexpr" in head or "consteval" in head or cursor.kind == CursorKind.VAR_DECL and "static " in head

    def add(self, cursor, operator: str, mutated: str):
        start, end = cursor.extent.start.offset, cursor.extent.end.offset
        line = cursor.extent.start.line
        context = self.text.splitlines()[line - 1].decode(errors="replace").strip() if operator == "number" else ""
        self.mutants.append(Mutant(self.path, line, operator, start, end, self.source(cursor), mutated, context=context))

    def add_sites(self, cursor, parent):
        kind = cursor.kind
        if kind == CursorKind.BINARY_OPERATOR:
            self.add_binary(cursor)
        elif kind == CursorKind.COMPOUND_ASSIGNMENT_OPERATOR:
            self.add_assignment(cursor, parent)
        elif kind == CursorKind.UNARY_OPERATOR:
            self.add_unary(cursor)
        elif kind in (CursorKind.INTEGER_LITERAL, CursorKind.FLOATING_LITERAL):
            self.add_number(cursor)
        elif kind == CursorKind.CALL_EXPR:
            self.add_call(cursor, parent)
        elif kind == CursorKind.IF_STMT:
            self.add_condition(cursor)
        elif kind == CursorKind.RETURN_STMT:
            self.add_return(cursor)

    def add_binary(self, cursor):
        children = list(cursor.get_children())
        if len(children) != 2:
            return
        left, right = children
        operator = self.text[left.extent.end.offset:right.extent.start.offset].decode(errors="replace").strip()
        operands = [side.type.get_canonical().kind for side in children]
        for table, types, name in ((RELATIONS, COMPARED, "relation"), (ARITHMETIC, NUMBERS, "arithmetic"), (LOGIC, NUMBERS, "logic")):
            if operator in table and all(kind in types for kind in operands):
                for other in table[operator]:
                    self.add(cursor, name, f"({self.source(left)}) {other} ({self.source(right)})")

    def add_assignment(self, cursor, parent):
        children = list(cursor.get_children())
        if len(children) != 2 or parent.kind != CursorKind.COMPOUND_STMT:
            return
        left, right = children
        operator = self.text[left.extent.end.offset:right.extent.start.offset].decode(errors="replace").strip()
        for other in ASSIGNMENTS.get(operator, []):
            self.add(cursor, "compound assignment", f"{self.source(left)} {other} {self.source(right)}")

    def add_unary(self, cursor):
        text = self.source(cursor)
        if text.startswith("-") and not text.startswith("--") and cursor.type.get_canonical().kind in NUMBERS:
            self.add(cursor, "sign", text[1:])
        elif text.startswith("!"):
            self.add(cursor, "negation", f"static_cast<bool>({text[1:]})")

    def add_number(self, cursor):
        text = self.source(cursor)
        if not text[:1].isdigit() and text[:1] != ".":
            return
        value = text.rstrip("uUlLfF") if not text.startswith("0x") else text
        is_zero = value.strip("0.'") == ""
        self.add(cursor, "number", "1" if is_zero else f"2 * {text}" if cursor.kind == CursorKind.FLOATING_LITERAL else f"{text} + 1")

    def add_call(self, cursor, parent):
        text = self.source(cursor)
        name = cursor.spelling
        if name in OPPOSITES and text.count(f"{name}(") == 1:
            self.add(cursor, "opposite function", text.replace(f"{name}(", f"{OPPOSITES[name]}("))
        # Not an assignment to an object of a class: that may be part of a declaration.
        if parent.kind == CursorKind.COMPOUND_STMT and not name.startswith("operator") and text.endswith(")"):
            self.add(cursor, "statement deleted", "")

    def add_condition(self, cursor):
        condition = next(iter(cursor.get_children()), None)
        if condition is None or condition.kind in (CursorKind.DECL_STMT, CursorKind.VAR_DECL) or ";" in self.source(condition):
            return
        head = self.text[cursor.extent.start.offset:condition.extent.start.offset].decode(errors="replace")
        if head.split() in (["if", "("], ["if("]) and condition.type.get_canonical().kind in COMPARED:
            self.add(condition, "condition negated", f"!({self.source(condition)})")

    def add_return(self, cursor):
        value = next(iter(cursor.get_children()), None)
        if value is not None and value.type.get_canonical().kind == TypeKind.BOOL and self.source(value) not in ("true", "false"):
            self.add(value, "return negated", f"!({self.source(value)})")


def apply(text: bytes, mutants: list[Mutant]) -> bytes:
    """Returns the text with the code of all these mutants. Pre: no two overlap."""
    for mutant in sorted(mutants, key=lambda m: m.start, reverse=True):
        text = text[:mutant.start] + mutant.code().encode() + text[mutant.end:]
    return text
