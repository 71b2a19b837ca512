"""Writes the reference of kerf.v1 from the descriptors of the .proto files and their comments: a page a file, in reStructuredText."""

import dataclasses
import pathlib
import re
import subprocess
import tempfile

from google.protobuf import descriptor_pb2

ROOT = pathlib.Path(__file__).resolve().parents[2]
FIELD = descriptor_pb2.FieldDescriptorProto
SCALARS = {value: name[len("TYPE_"):].lower() for name, value in FIELD.Type.items()}
# Calls with a stream on a side have paths of their own; all others are POST /SERVICE/METHOD.
STREAM_PATHS = {
    "kerf.v1.StreamService.Watch": "WebSocket /watch",
    "kerf.v1.StreamService.Subscribe": "",
    "kerf.v1.RenderService.WatchImages": "WebSocket /images",
    "kerf.v1.SheetService.UploadSheet": "POST /sheets?format=obj|ply&request=JSON",
    "kerf.v1.SheetService.ReplayRecording": "POST /recordings?sheet=ID&paused=true",
    "kerf.v1.SheetService.GetSheetRecording": "GET /sheets/ID.rec",
}


def descriptors():
    """Returns the descriptors of kerf.v1 with their comments, in the order of their names."""
    with tempfile.TemporaryDirectory() as folder:
        out = pathlib.Path(folder, "kerf.pb")
        files = sorted(str(path) for path in (ROOT / "proto/kerf/v1").glob("*.proto"))
        subprocess.run(["protoc", "-I", str(ROOT / "proto"), "--include_source_info", f"--descriptor_set_out={out}", *files], check=True)
        return list(descriptor_pb2.FileDescriptorSet.FromString(out.read_bytes()).file)


@dataclasses.dataclass
class Item:
    """A service, method, message, field, enum or value."""
    kind: str
    name: str  # with its package: kerf.v1.Scene.grid
    comment: str
    proto: object
    items: list = dataclasses.field(default_factory=list)

    @property
    def short(self):
        return self.name.rsplit(".", 1)[1]


def read_items(file):
    """Returns the services, messages and enums of a file."""
    comments = {}
    for location in file.source_code_info.location:
        comments[tuple(location.path)] = "\n".join(filter(None, (location.leading_comments, location.trailing_comments)))

    def item(kind, proto, scope, path):
        name = f"{scope}.{proto.name}"
        made = Item(kind, name, comments.get(path, ""), proto)
        members = {"service": ((2, "method", "method"),), "enum": ((2, "value", "value"),),
                   "message": ((2, "field", "field"), (3, "nested_type", "message"), (4, "enum_type", "enum"))}.get(kind, ())
        for number, attribute, member_kind in members:
            for index, member in enumerate(getattr(proto, attribute)):
                if not (member_kind == "message" and member.options.map_entry):
                    made.items.append(item(member_kind, member, name, (*path, number, index)))
        return made

    groups = ((6, "service", "service"), (4, "message_type", "message"), (5, "enum_type", "enum"))
    return [item(kind, proto, file.package, (number, index))
            for number, attribute, kind in groups for index, proto in enumerate(getattr(file, attribute))]


def everything(items):
    for item in items:
        yield item
        yield from everything(item.items)


class Writer:
    """Writes items; knows every name, so that comments can link to them."""

    def __init__(self, items):
        self.items = {item.name: item for item in items}
        # Names that stand in comments without their scope. A field is in none: too many have the same name.
        self.by_short = {}
        for item in items:
            if item.kind not in ("field", "value"):
                self.by_short.setdefault(item.short, []).append(item.name)

    def reference(self, name, text):
        return f":kerf:`{text} <{name}>`" if name in self.items else f"``{text}``"

    def find(self, text, scope):
        """Returns the name that a word of the comment of `scope` means, innermost first, or nothing; never that of `scope` itself."""
        first, _, rest = text.partition(".")
        outer = scope.split(".")
        found = [".".join((*outer[:i], text)) for i in range(len(outer), 0, -1)]
        found += [f"{name}.{rest}" if rest else name for name in self.by_short.get(first, ())]
        return next((name for name in found if name in self.items and name != scope), "")

    def words(self, text, scope):
        """Returns prose without code. Names in CamelCase, with a member or with an underscore become links, or code if nothing has them."""
        out, end = "", 0
        for match in re.finditer(r"\b[A-Za-z][A-Za-z0-9]*(?:[._][A-Za-z0-9_]+)*\b", text):
            word = match.group()
            is_member = "." in word and self.find(word, scope)
            if "_" in word or is_member or (re.fullmatch(r"(?:[A-Z][a-z0-9]+){2,}", word) and self.find(word, scope)):
                out += escaped(text[end:match.start()]) + self.code(word, scope)
                end = match.end()
        return out + escaped(text[end:])

    def prose(self, comment, scope):
        """Returns the paragraphs of a comment. Lines that are set in stand as they are."""
        paragraphs = []
        for paragraph in re.split(r"\n[ \t]*\n", comment.strip("\n")):
            lines = [line[1:] if line.startswith(" ") else line for line in paragraph.split("\n")]
            text = ""
            for line in lines:
                if line.startswith("  ") and line.strip():
                    text = text.rstrip("\n") + "\n\n::\n\n  " + line.strip() + "\n\n"
                else:
                    text += line.strip() + "\n"
            for block in re.split(r"\n{2,}", text.strip("\n")):
                if block.startswith(("::", "  ")):
                    paragraphs.append(block)
                elif block.strip():
                    parts = re.split(r"`([^`]*)`", " ".join(block.split()))
                    text = "".join(self.code(part, scope) if i % 2 else self.words(part, scope) for i, part in enumerate(parts))
                    paragraphs.append(re.sub(r"^(\\ )+|(\\ )+$", "", text))
        return "\n\n".join(paragraphs)

    def code(self, text, scope):
        name = self.find(text, scope) if re.fullmatch(r"[A-Za-z_][\w.]*", text) else ""
        return f"\\ {self.reference(name, text) if name else f'``{text}``'}\\ "

    def type_of(self, field, message):
        """Returns the label of a field's type, what stands before and after it, and the name that it leads to."""
        before = "repeated " if field.label == FIELD.LABEL_REPEATED else "optional " if field.proto3_optional else ""
        after = ""
        for entry in message.nested_type:
            if entry.options.map_entry and field.type_name.endswith(f".{message.name}.{entry.name}"):
                key, field = entry.field
                before, after = f"map<{SCALARS[key.type]}, ", ">"
        if field.type in (FIELD.TYPE_MESSAGE, FIELD.TYPE_ENUM):
            name = field.type_name[1:]
            return before, name.removeprefix("kerf.v1."), after, name if name in self.items else ""
        return before, SCALARS[field.type], after, ""

    def members(self, item):
        """Returns the fields of a message or the values of an enum."""
        text = ""
        for member in item.items:
            if member.kind == "field":
                oneof = ""
                if member.proto.HasField("oneof_index") and not member.proto.proto3_optional:
                    oneof = item.proto.oneof_decl[member.proto.oneof_index].name
                signature = "|".join((member.name, *self.type_of(member.proto, item.proto), str(member.proto.number), oneof))
            elif member.kind == "value":
                signature = f"{member.name}|||||{member.proto.number}|"
            else:
                continue
            text += f".. kerf:: {signature}\n\n{indented(self.prose(member.comment, member.name))}\n\n"
        return text

    def method(self, item):
        proto = item.proto
        request, reply = proto.input_type[1:], proto.output_type[1:]
        streams = ("stream " if proto.client_streaming else "", "stream " if proto.server_streaming else "")
        sides = [stream + self.reference(name, name.removeprefix("kerf.v1.")) for stream, name in zip(streams, (request, reply))]
        path = http_path(item)
        lines = [f"| Request: {sides[0]}", f"| Reply: {sides[1]}",
                 f"| HTTP: ``{path}``" if path else "| HTTP: none; gRPC alone"]
        return "\n".join(lines) + "\n\n"

    def section(self, item, level):
        title = item.name.removeprefix("kerf.v1.") if item.kind != "method" else item.short
        text = f".. kerf-target:: {item.name}\n\n{heading(title, level)}"
        if item.kind == "method":
            text += self.method(item)
        text += f"{self.prose(item.comment, item.name)}\n\n{self.members(item)}"
        for member in item.items:
            if member.kind in ("method", "message", "enum"):
                text += self.section(member, level + 1)
        return text

    def page(self, file, items):
        name = pathlib.PurePosixPath(file.name).stem
        return heading(name.capitalize(), 0) + f"Declared in ``proto/{file.name}``.\n\n" + "".join(self.section(item, 1) for item in items)

    def summary(self, item):
        """Returns the first sentence of a comment, or of that which it leads to."""
        see = re.match(r"\s*See (\w+)\.", item.comment)
        if see and self.find(see[1], item.name):
            item = self.items[self.find(see[1], item.name)]
        return re.split(r"(?<=[.:;]) ", self.prose(item.comment, item.name).replace("\n", " "))[0].rstrip(":;")

    def index(self, pages):
        text = heading("Calls and messages", 0)
        text += ("Every call of the package ``kerf.v1`` works over gRPC. Calls without a stream work as JSON over HTTP, too: ``POST`` the "
                 "request to the path of the call. :doc:`/proto/README` specifies the transports and the live stream.\n\n"
                 ".. code-block:: sh\n\n   curl -s http://127.0.0.1:8080/kerf.v1.SheetService/ListSheets -d '{}'\n\n"
                 "In JSON, names of fields are as here, or in lowerCamelCase. A refusal is a ``google.rpc.Status``: "
                 ":doc:`/server/README` has a table of the reasons.\n\n")
        for items in pages.values():
            for service in (item for item in items if item.kind == "service"):
                text += heading(service.short, 1)
                text += ".. list-table::\n   :header-rows: 1\n   :widths: 28 44 28\n\n   * - call\n     - what it does\n     - HTTP\n"
                for method in service.items:
                    path = http_path(method)
                    text += (f"   * - {self.reference(method.name, method.short)}\n     - {self.summary(method)}\n"
                             f"     - {f'``{path}``' if path else 'none'}\n")
                text += "\n"
        text += heading("Files", 1) + ".. toctree::\n   :maxdepth: 1\n\n" + "".join(f"   {page}\n" for page in pages)
        return text


def http_path(method):
    """Returns how a call is made without gRPC; empty if it cannot be."""
    if method.proto.client_streaming or method.proto.server_streaming:
        return STREAM_PATHS[method.name]
    return "POST /" + "/".join(method.name.rsplit(".", 1))


def escaped(text):
    return re.sub(r"([\\`*_|<>\[\]:])", r"\\\1", text)


def indented(text):
    return "\n".join("   " + line if line else "" for line in text.split("\n"))


def heading(title, level):
    line = "=-~^\""[level] * len(title)
    return f"{title}\n{line}\n\n"


def references():
    """Returns the text of each page by its path."""
    files = descriptors()
    pages = {pathlib.PurePosixPath(file.name).stem: read_items(file) for file in files}
    writer = Writer(list(everything(item for items in pages.values() for item in items)))
    texts = {f"reference/api/{pathlib.PurePosixPath(file.name).stem}.rst":
             writer.page(file, pages[pathlib.PurePosixPath(file.name).stem]) for file in files}
    texts["reference/api/index.rst"] = writer.index(pages)
    return texts
