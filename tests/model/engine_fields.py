"""Which file of the engine reads or writes which field of which struct, found by a parser of C."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path
from typing import Any, NamedTuple

from pycparser import c_ast, c_parser

COMPILER = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
# the code without extensions of a compiler, which is that for any scalar
PLAIN = ("-E", "-std=c99", "-U__GNUC__", "-nostdinc", "-D__attribute__(x)=")
STANDARD = "typedef unsigned long size_t;\ntypedef long time_t;\n"
MARKER = re.compile(r'^# \d+ "([^"]*)".*$', re.MULTILINE)


class Access(NamedTuple):
    """A field of a struct that the file `owner` defines, read or written in `file`.

    `content` is the file that defines the struct of the field, "" for numbers.
    """

    owner: str
    struct: str
    field: str
    file: str
    content: str = ""


class Reader:
    """The types of the headers, and the accesses that have been found.

    A type is ("to", type) for pointers, arrays and functions, the key of a struct, or None.
    """

    def __init__(self) -> None:
        self.typedefs: dict[str, Any] = {}
        self.variables: dict[str, Any] = {}
        self.structs: dict[Any, dict[str, Any]] = {}
        self.names: dict[Any, str] = {}
        self.owners: dict[Any, str] = {}
        self.found: set[Access] = set()

    def read(self, text: str, file: str) -> None:
        """Read a text whose line markers say which file it is."""
        for node in c_parser.CParser().parse(text, file).ext:
            if isinstance(node, c_ast.Typedef):
                if node.coord.file == "<stubs>":
                    continue
                kind = self.typedefs[node.name] = self.type_of(node.type)
                if self.names.get(kind) == kind:
                    self.names[kind] = node.name
            elif isinstance(node, c_ast.FuncDef):
                self.variables[node.decl.name] = self.type_of(node.decl.type)
                parameters = node.decl.type.args.params if node.decl.type.args else []
                names = {p.name: self.type_of(p.type) for p in parameters if hasattr(p, "name")}
                self.walk(node.body, names)
            elif isinstance(node, c_ast.Decl):
                self.declare(node, self.variables)

    def type_of(self, node: Any) -> Any:
        if isinstance(node, c_ast.PtrDecl | c_ast.ArrayDecl | c_ast.FuncDecl):
            return ("to", self.type_of(node.type))
        if isinstance(node, c_ast.TypeDecl | c_ast.Typename):
            return self.type_of(node.type)
        if isinstance(node, c_ast.IdentifierType):
            return self.typedefs.get(node.names[-1])
        if not isinstance(node, c_ast.Struct):
            return None
        key = node.name or str(node.coord)
        if node.decls is not None and key not in self.structs:
            self.owners[key] = node.coord.file
            self.names.setdefault(key, key)
            self.structs[key] = {}
            self.structs[key] |= {field.name: self.type_of(field.type) for field in node.decls}
        return key

    def declare(self, node: Any, names: dict[str, Any]) -> None:
        kind = self.type_of(node.type)
        if node.name:
            names[node.name] = kind
        if node.init is not None:
            self.walk(node.init, names)

    def walk(self, node: Any, names: dict[str, Any]) -> Any:
        """Follow a statement or an expression, note accesses and return the type of its value."""
        if isinstance(node, c_ast.Compound | c_ast.For):
            names = dict(names)
        if isinstance(node, c_ast.Decl):
            return self.declare(node, names)
        if isinstance(node, c_ast.ID):
            return names.get(node.name, self.variables.get(node.name))
        if isinstance(node, c_ast.StructRef):
            struct = self.walk(node.name, names)
            struct = struct[1] if node.type == "->" and struct else struct
            if struct in self.structs:
                owner, name = self.owners[struct], self.names[struct]
                content = self.owners.get(_pointed(self.structs[struct].get(node.field.name)), "")
                self.found.add(Access(owner, name, node.field.name, node.coord.file, content))
            return self.structs.get(struct, {}).get(node.field.name)
        kinds = [self.walk(child, names) for _, child in node.children()]
        if isinstance(node, c_ast.UnaryOp) and node.op == "&":
            return ("to", kinds[0])
        if isinstance(node, c_ast.ArrayRef | c_ast.FuncCall) or getattr(node, "op", "") == "*":
            kind = kinds[0][1] if _is_pointer(kinds[0]) else None
            by_pointer = isinstance(node, c_ast.FuncCall) and not isinstance(node.name, c_ast.ID)
            return kind[1] if by_pointer and _is_pointer(kind) else kind
        if isinstance(node, c_ast.Cast | c_ast.CompoundLiteral):
            return self.type_of(node.to_type if isinstance(node, c_ast.Cast) else node.type)
        if isinstance(node, c_ast.Typename):
            return None
        if isinstance(node, c_ast.TernaryOp):
            return kinds[1] or kinds[2]
        if isinstance(node, c_ast.BinaryOp | c_ast.Assignment | c_ast.UnaryOp):
            return next((kind for kind in kinds if _is_pointer(kind)), kinds[0])
        return None


def _is_pointer(kind: Any) -> bool:
    return isinstance(kind, tuple)


def _pointed(kind: Any) -> Any:
    while _is_pointer(kind):
        kind = kind[1]
    return kind


def accesses(engine: Path, files: list[Path], empty: Path) -> set[Access]:
    """All of the files, by their places in the engine; `empty` is a folder for empty headers."""
    headers = [path for path in files if path.suffix == ".h"]
    texts = {path: path.read_text("utf-8") for path in files}
    for header in re.findall(r"#include <(\w+\.h)>", "".join(texts.values())):
        (empty / header).touch()

    def pieces(text: str) -> str:
        command = [str(COMPILER), *PLAIN, f"-I{empty}", f"-I{engine}", "-x", "c", "-"]
        made = subprocess.run(
            command, input=text, capture_output=True, text=True, check=True, cwd=empty
        )
        parts = MARKER.split(made.stdout)[1:]
        return "\n".join(
            f'# 1 "{Path(file).relative_to(engine) if file != "<stdin>" else file}"\n{piece}'
            for file, piece in zip(parts[::2], parts[1::2], strict=True)
            if file == "<stdin>" or Path(file).is_relative_to(engine)
        )

    reader = Reader()
    every = "".join(f'#include "{p.relative_to(engine)}"\n' for p in headers)
    reader.read(STANDARD + pieces(every), "<stdin>")
    stubs = '# 1 "<stubs>"\n' + "".join(f"typedef int {name};\n" for name in reader.typedefs)
    outer = dict(reader.typedefs), dict(reader.variables)
    for path in sorted(texts.keys() - set(headers)):
        reader.typedefs, reader.variables = dict(outer[0]), dict(outer[1])
        place = str(path.relative_to(engine))
        own = pieces(f'# 1 "{path}"\n' + texts[path])
        own = "".join(
            f'# 1 "{file}"\n{piece}'
            for file, piece in zip(*[iter(MARKER.split(own)[1:])] * 2, strict=True)
            if file == place
        )
        reader.read(stubs + own, place)
    return reader.found
