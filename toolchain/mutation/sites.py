# SPDX-License-Identifier: Apache-2.0
"""Where a source can be changed by one fault: its syntax tree, as libclang reads it, becomes sites with mutants."""
import re
import subprocess
from dataclasses import dataclass, field

from clang import cindex
from clang.cindex import CursorKind as K
from clang.cindex import TypeKind as T

FUNCTIONS = {K.FUNCTION_DECL, K.CXX_METHOD, K.CONSTRUCTOR, K.FUNCTION_TEMPLATE, K.CONVERSION_FUNCTION, K.DESTRUCTOR}
SCOPES = {K.NAMESPACE, K.CLASS_DECL, K.STRUCT_DECL, K.CLASS_TEMPLATE, K.LINKAGE_SPEC, K.UNEXPOSED_DECL}
SKIPPED = {K.STATIC_ASSERT, K.ENUM_DECL, K.ENUM_CONSTANT_DECL, K.CXX_UNARY_EXPR, K.TYPE_REF, K.TEMPLATE_REF,
           K.NAMESPACE_REF, K.CXX_NOEXCEPT_EXPR if hasattr(K, "CXX_NOEXCEPT_EXPR") else K.STATIC_ASSERT}
BOUNDARY = {"<": ("<=", "less"), "<=": ("<", "less_equal"), ">": (">=", "more"), ">=": (">", "more_equal")}
NEGATED = {"<": ">=", "<=": ">", ">": "<=", ">=": "<", "==": "!=", "!=": "=="}
SWAPPED = {"+": ("-", "plus"), "-": ("+", "minus"), "*": ("/", "times"), "/": ("*", "over"), "%": ("*", "rest"),
           "&": ("|", "bit_and"), "|": ("&", "bit_or"), "<<": (">>", "left"), ">>": ("<<", "right")}
OPERATORS = sorted({*NEGATED, *SWAPPED, "&&", "||", "=", *(op + "=" for op in SWAPPED)}, key=len, reverse=True)
INTEGERS = {T.BOOL, T.CHAR_U, T.UCHAR, T.USHORT, T.UINT, T.ULONG, T.ULONGLONG, T.CHAR_S, T.SCHAR, T.SHORT, T.INT,
            T.LONG, T.LONGLONG}
DOUBLED_FROM = 1000  # a literal from here on is doubled: one more of so many is no fault that matters
COMMENT = re.compile(rb"//[^\n]*|/\*.*?\*/", re.DOTALL)


@dataclass
class Mutant:
    role: str
    change: str
    number: int = -1


@dataclass
class Site:
    start: int
    end: int
    depth: int
    line: int
    column: int
    function: str
    mutants: list = field(default_factory=list)
    operator: tuple = ()  # its range, with lhs and rhs around it
    text: str = ""
    kind: str = ""
    cast: str = ""


class Unreadable(Exception):
    """libclang does not understand a file."""


def parser_flags(words):
    """Of a compiler's command: what libclang needs to know, and GCC's own headers."""
    flags, take = [], False
    for word in words[1:]:
        if take or word.startswith(("-I", "-D", "-std=")):
            flags.append(word)
            take = False
        elif word == "-isystem":
            flags.append(word)
            take = True
    own = subprocess.run([words[0], "-print-file-name=include"], capture_output=True, text=True, check=True)
    return ["-xc++", *flags, "-isystem", own.stdout.strip(), "-w"]


class Reader:
    """Sites of one file."""

    def __init__(self, path, flags):
        options = cindex.TranslationUnit.PARSE_DETAILED_PROCESSING_RECORD
        self.unit = cindex.Index.create().parse(str(path), args=flags, options=options)
        wrong = [str(said) for said in self.unit.diagnostics if said.severity >= cindex.Diagnostic.Error]
        if wrong:
            raise Unreadable("\n".join(wrong[:5]))
        self.path, self.data = str(path), path.read_bytes()
        self.bare = COMMENT.sub(lambda match: b" " * len(match[0]), self.data)
        self.macros = [self.range(node) for node in self.unit.cursor.get_children()
                       if node.kind == K.MACRO_INSTANTIATION and self.here(node)]
        self.sites, self.constants, self.fixed, self.used = [], {}, [], set()
        self.functions, self.results, self.depth = [], [], 0

    def here(self, node):
        return node.location.file is not None and node.location.file.name == self.path

    @staticmethod
    def range(node):
        return node.extent.start.offset, node.extent.end.offset

    def text(self, node):
        start, end = self.range(node)
        return " ".join(self.data[start:end].decode().split())

    def read(self):
        for node in self.unit.cursor.get_children():
            if self.here(node):
                self.declaration(node)
        self.sites = [site for site in self.sites if site.mutants]
        self.fixed += [name for name in self.constants.values() if name not in self.used]
        return self

    def declaration(self, node):
        if node.kind in FUNCTIONS:
            if node.is_definition() or node.kind == K.FUNCTION_TEMPLATE:
                self.function(node)
        elif node.kind == K.VAR_DECL and self.is_constant(node):
            self.constants[node.get_usr()] = node.spelling
        elif node.kind in SCOPES:
            for inner in node.get_children():
                self.declaration(inner)

    def is_constant(self, node):
        start = node.extent.start.offset
        head = self.bare[start:node.location.offset]
        return b"constexpr" in head

    def can_double(self, node):
        kind = node.type.get_canonical()
        if kind.kind in INTEGERS:
            return True
        return any(method.spelling == "from_raw" for method in kind.get_declaration().get_children()) or (
            "from_raw" in self.text(node))

    def function(self, node):
        self.functions.append(node.spelling if not self.functions else self.functions[-1])
        self.results.append(node.result_type)
        for inner in node.get_children():
            if inner.kind == K.COMPOUND_STMT:
                self.visit(inner, node)
        self.functions.pop()
        self.results.pop()

    def visit(self, node, parent):
        start, end = self.range(node)
        if node.kind in SKIPPED or end <= start or any(a <= start < b for a, b in self.macros):
            return
        if node.kind == K.VAR_DECL and self.is_constant(node):
            self.constants[node.get_usr()] = node.spelling
            return
        self.depth += 1
        if node.kind == K.LAMBDA_EXPR:
            self.results.append(None)
        self.statement(node, parent)
        self.condition(node)
        self.expression(node, parent)
        children = list(node.get_children())
        if node.kind == K.CASE_STMT:
            children = children[1:]
        if node.kind in (K.VAR_DECL, K.FIELD_DECL):
            children = [child for child in children if child.extent.start.offset > node.location.offset
                        and not self.is_bound(child)]
        for child in children:
            self.visit(child, node)
        if node.kind == K.LAMBDA_EXPR:
            self.results.pop()
        self.depth -= 1

    def is_bound(self, node):
        start, end = self.range(node)
        return self.bare[:start].rstrip().endswith(b"[") and self.bare[end:].lstrip().startswith(b"]")

    def site(self, node, kind, **more):
        start, end = self.range(node)
        place = node.extent.start
        site = Site(start, end, self.depth * 4 + {"statement": 0, "force": 1, "negate": 2}.get(kind, 3), place.line,
                    place.column, self.functions[-1], kind=kind, text=self.text(node), **more)
        self.sites.append(site)
        return site

    def statement(self, node, parent):
        inner = list(parent.get_children())
        place = inner.index(node) if node in inner else -1
        if parent.kind in (K.FOR_STMT, K.WHILE_STMT, K.CXX_FOR_RANGE_STMT, K.CASE_STMT, K.DEFAULT_STMT):
            stands = place == len(inner) - 1
        else:
            before = self.bare[:self.range(node)[0]].rstrip()
            stands = parent.kind == K.COMPOUND_STMT or (
                parent.kind == K.IF_STMT and place > 0 and before.endswith((b")", b"else")))
        if not stands:
            return
        semicolon = self.bare.find(b";", self.range(node)[1] - 1)
        if node.kind == K.RETURN_STMT:
            self.returned(node, semicolon)
        elif node.kind in (K.CALL_EXPR, K.COMPOUND_ASSIGNMENT_OPERATOR, K.BINARY_OPERATOR, K.UNARY_OPERATOR,
                           K.UNEXPOSED_EXPR, K.BREAK_STMT, K.CONTINUE_STMT):
            site = self.site(node, "statement")
            site.end = semicolon + 1
            site.mutants.append(Mutant("delete", f"{site.text}; -> (nothing)"))

    def returned(self, node, semicolon):
        inner = list(node.get_children())
        if not inner:
            return
        value, result = inner[0], self.results[-1]
        text = self.text(value)
        kind = (result or value.type).get_canonical().kind
        if kind == T.BOOL:
            if self.operator(value)[0] not in NEGATED and not text.startswith("!"):
                self.site(value, "negate").mutants.append(Mutant("negate", f"return {text} -> return !({text})"))
        elif result is not None and kind not in (T.LVALUEREFERENCE, T.RVALUEREFERENCE, T.VOID) and (
                text not in ("0", "nullptr") and not text.endswith("{}") and "auto" not in result.spelling):
            site = self.site(node, "statement")
            site.end = semicolon + 1
            site.mutants.append(Mutant("default", f"return {text} -> return {{}}"))

    def condition(self, node):
        inner = list(node.get_children())
        tested = None
        if node.kind in (K.IF_STMT, K.WHILE_STMT, K.CONDITIONAL_OPERATOR) and inner:
            tested = inner[0]
            if self.bare[self.range(node)[0]:self.range(tested)[0]].split(b"(")[0].strip().endswith(b"constexpr"):
                return
        elif node.kind == K.FOR_STMT:
            first = self.bare.find(b";", self.range(node)[0])
            second = self.bare.find(b";", first + 1)
            tested = next((child for child in inner if first < self.range(child)[0] < second), None)
        if tested is None or tested.kind in (K.VAR_DECL, K.DECL_STMT, K.CXX_BOOL_LITERAL_EXPR, K.INTEGER_LITERAL):
            return
        operator = self.operator(tested)[0]
        self.force(tested, [value for value, covered in (("true", "||"), ("false", "&&")) if operator != covered])

    def force(self, node, values):
        site = self.site(node, "force")
        site.mutants += [Mutant(value, f"{site.text} -> {value}") for value in values]

    def operator(self, node):
        """(operator, its range, lhs, rhs) of a binary operator, built in or of a class."""
        none = ("", (), None, None)
        while node.kind in (K.UNEXPOSED_EXPR, K.PAREN_EXPR):
            inner = list(node.get_children())
            if len(inner) != 1:
                return none
            node = inner[0]
        inner = list(node.get_children())
        if node.kind == K.CALL_EXPR and node.spelling.startswith("operator"):
            inner = [child for child in inner if not (child.kind in (K.UNEXPOSED_EXPR, K.DECL_REF_EXPR)
                                                      and child.spelling.startswith("operator")
                                                      and self.text(child) in OPERATORS)]
        elif node.kind not in (K.BINARY_OPERATOR, K.COMPOUND_ASSIGNMENT_OPERATOR):
            return none
        if len(inner) != 2:
            return none
        start, end = self.range(inner[0])[1], self.range(inner[1])[0]
        between = self.bare[start:end]
        text = between.strip().decode()
        if text not in OPERATORS:
            return none
        at = start + between.index(text.encode())
        return text, (at, at + len(text)), inner[0], inner[1]

    def expression(self, node, parent):
        if node.kind in (K.BINARY_OPERATOR, K.COMPOUND_ASSIGNMENT_OPERATOR, K.CALL_EXPR):
            self.binary(node, parent)
        text = self.data[self.range(node)[0]:self.range(node)[0] + 1]
        own = node.kind == K.UNARY_OPERATOR or (node.kind == K.CALL_EXPR and node.spelling == "operator-"
                                                and not self.operator(node)[0])
        if own and text == b"!":
            site = self.site(node, "negate")
            site.mutants.append(Mutant("negate", f"{site.text} -> {site.text[1:].strip()}"))
        elif own and text == b"-" and self.data[self.range(node)[0]:][:2] != b"--":
            begin = self.range(node)[0]
            site = self.site(node, "minus", operator=(begin, begin + 1))
            site.mutants.append(Mutant("minus", f"{site.text} -> {site.text[1:].strip()}"))
        elif node.kind == K.INTEGER_LITERAL:
            self.literal(node, parent)
        elif node.kind == K.CXX_BOOL_LITERAL_EXPR and parent.kind != K.RETURN_STMT:
            site = self.site(node, "negate")
            site.mutants.append(Mutant("negate", f"{site.text} -> {'false' if site.text == 'true' else 'true'}"))
        elif node.kind == K.DECL_REF_EXPR and node.referenced is not None:
            self.constant(node)

    def binary(self, node, parent):
        operator, where, left, right = self.operator(node)
        if not operator or operator == "=":
            return
        a, b = self.text(left), self.text(right)
        if operator in ("&&", "||"):
            other, value = ("||", "true") if operator == "&&" else ("&&", "false")
            site = self.site(node, "logic", operator=where)
            site.mutants.append(Mutant(operator, f"{a} {operator} {b} -> {a} {other} {b}"))
            for operand in (left, right):
                if self.operator(operand)[0] != operator:
                    self.depth += 1
                    self.force(operand, [value])
                    self.depth -= 1
            if self.operator(parent)[0] != operator:
                opposite = "false" if value == "true" else "true"
                self.force(node, [opposite])
            return
        if operator in NEGATED:
            site = self.site(node, "negate")
            site.mutants.append(Mutant("negate", f"{a} {operator} {b} -> {a} {NEGATED[operator]} {b}"))
        if operator in BOUNDARY:
            other, helper = BOUNDARY[operator]
        elif operator in SWAPPED:
            other, helper = SWAPPED[operator]
        elif operator[:-1] in SWAPPED:
            other, helper = SWAPPED[operator[:-1]]
            other, helper = other + "=", helper + "_to"
        else:
            return
        site = self.site(node, "call", operator=where)
        site.mutants.append(Mutant(helper, f"{a} {operator} {b} -> {a} {other} {b}"))

    def literal(self, node, parent):
        text = self.text(node)
        found = re.match(r"(0[xX][0-9a-fA-F']+|0[bB][01']+|[0-9']+)", text)
        if not found or self.is_bound(node) and parent.kind != K.ARRAY_SUBSCRIPT_EXPR:
            return
        value = int(found[0].replace("'", ""), 0) if not re.match(r"0[0-7']+$", found[0]) else int(found[0], 8)
        suffix = text[found.end():]
        cast = parent.type.spelling if (parent.kind == K.UNEXPOSED_EXPR and parent.type.get_canonical().kind in INTEGERS
                                        and self.range(parent) == self.range(node)) else ""
        site = self.site(node, "literal", cast=cast)
        for other in {0: [1], 1: [0, 2]}.get(value, [2 * value if value >= DOUBLED_FROM else value + 1]):
            site.mutants.append(Mutant(f"{other}{suffix}", f"{text} -> {other}{suffix}"))

    def constant(self, node):
        name = self.constants.get(node.referenced.get_usr())
        if name is None:
            return
        if not self.can_double(node.referenced):
            return
        self.used.add(name)
        site = self.site(node, "constant")
        site.line, site.column = node.referenced.location.line, node.referenced.location.column
        site.mutants.append(Mutant(f"constant {node.referenced.get_usr()}",
                                   f"{self.text(node.referenced)} -> doubled"))
