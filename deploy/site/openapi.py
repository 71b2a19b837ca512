#!/usr/bin/python3
"""Writes openapi.json: the JSON calls of kerf.v1 as OpenAPI 3.1, from the descriptors of the .proto files and their comments.

    deploy/site/openapi.py FILE
"""

import json
import pathlib
import re
import sys

from google.protobuf import descriptor_pb2

import api_pages

FIELD = descriptor_pb2.FieldDescriptorProto
NUMBER = {"anyOf": [{"type": "number"}, {"enum": ["NaN", "Infinity", "-Infinity"]}]}
# 64-bit integers are texts in the JSON form of Protocol Buffers; the server also takes numbers.
LONG = {"type": ["string", "integer"], "pattern": "^-?[0-9]+$"}
SCALARS = {
    FIELD.TYPE_DOUBLE: NUMBER, FIELD.TYPE_FLOAT: NUMBER, FIELD.TYPE_INT64: {**LONG, "format": "int64"}, FIELD.TYPE_UINT64: {**LONG, "format": "uint64"},
    FIELD.TYPE_SINT64: {**LONG, "format": "int64"}, FIELD.TYPE_FIXED64: {**LONG, "format": "uint64"}, FIELD.TYPE_INT32: {"type": "integer", "format": "int32"},
    FIELD.TYPE_UINT32: {"type": "integer", "format": "uint32", "minimum": 0}, FIELD.TYPE_SINT32: {"type": "integer", "format": "int32"},
    FIELD.TYPE_FIXED32: {"type": "integer", "format": "uint32", "minimum": 0}, FIELD.TYPE_BOOL: {"type": "boolean"}, FIELD.TYPE_STRING: {"type": "string"},
    FIELD.TYPE_BYTES: {"type": "string", "contentEncoding": "base64"},
}
FOREIGN = {"google.protobuf.Empty": {"type": "object", "additionalProperties": False}}
STATUS = {
    "type": "object", "description": "google.rpc.Status: why a call was refused.",
    "properties": {
        "code": {"type": "integer", "description": "A code of gRPC, such as 5 for NOT_FOUND."},
        "message": {"type": "string"},
        "details": {"type": "array", "items": {"type": "object", "properties": {
            "@type": {"type": "string"},
            "reason": {"type": "string", "description": "A stable name, such as SHEET_NOT_FOUND: of google.rpc.ErrorInfo."}},
            "required": ["@type"]}},
    }, "required": ["code", "message"]}


def prose(comment):
    """Returns a comment as one paragraph for each of its own."""
    return "\n\n".join(" ".join(part.split()) for part in re.split(r"\n[ \t]*\n", comment.strip()) if part.strip())


def camel(name):
    return re.sub(r"_(\w)", lambda match: match.group(1).upper(), name)


def schema_of_field(field, message):
    for entry in message.nested_type:
        if entry.options.map_entry and field.type_name.endswith(f".{message.name}.{entry.name}"):
            return {"type": "object", "additionalProperties": schema_of_type(entry.field[1])}
    schema = schema_of_type(field)
    return {"type": "array", "items": schema} if field.label == FIELD.LABEL_REPEATED else schema


def schema_of_type(field):
    if field.type in (FIELD.TYPE_MESSAGE, FIELD.TYPE_ENUM):
        return {"$ref": f"#/components/schemas/{field.type_name[1:]}"}
    return dict(SCALARS[field.type])


def schema_of_message(item):
    properties = {}
    choices = {}
    for member in item.items:
        if member.kind != "field":
            continue
        schema = schema_of_field(member.proto, item.proto)
        description = prose(member.comment)
        if member.proto.HasField("oneof_index") and not member.proto.proto3_optional:
            choices.setdefault(item.proto.oneof_decl[member.proto.oneof_index].name, []).append(member.short)
        if description:
            schema = {**schema, "description": description}
        properties[member.short] = schema
    made = {"type": "object", "properties": properties, "additionalProperties": False}
    text = [prose(item.comment)] + [f"At most one of {', '.join(names)} ({name})." for name, names in choices.items()]
    made["description"] = "\n\n".join(filter(None, text))
    return {name: value for name, value in made.items() if value != ""}


def schema_of_enum(item):
    values = [f"{value.short}: {prose(value.comment)}" for value in item.items if value.comment.strip()]
    description = "\n\n".join(filter(None, [prose(item.comment), *values]))
    made = {"type": "string", "enum": [value.short for value in item.items]}
    return {**made, "description": description} if description else made


def references(schema):
    """Yields the names of all schemas that a part of the document refers to."""
    if isinstance(schema, dict):
        if "$ref" in schema:
            yield schema["$ref"].rsplit("/", 1)[1]
        schema = list(schema.values())
    if isinstance(schema, list):
        for part in schema:
            yield from references(part)


def operation(service, method):
    proto = method.proto
    text = prose(method.comment)

    def content(name):
        return {"application/json": {"schema": {"$ref": f"#/components/schemas/{name[1:]}"}}}

    return {
        "tags": [service.short], "operationId": f"{service.short}_{method.short}", "summary": text.split(". ")[0].rstrip("."), "description": text,
        "requestBody": {"required": False, "content": content(proto.input_type), "description": "No body is the empty message."},
        "responses": {"200": {"description": "The call was done.", "content": content(proto.output_type)},
                      "default": {"description": "The call was refused.",
                                  "content": {"application/json": {"schema": {"$ref": "#/components/schemas/google.rpc.Status"}}}}}}


def plain_get(summary, *others):
    answers = {"200": {"description": "The answer.", "content": {"text/plain": {"schema": {"type": "string"}}}}}
    return {"get": {"tags": ["Server"], "operationId": camel("get_" + re.sub(r"\W+", "_", summary.lower())[:40].strip("_")), "summary": summary,
                    "responses": {**answers, **{status: {"description": text} for status, text in others}}}}


def document():
    items = [item for file in api_pages.descriptors() for item in api_pages.read_items(file)]
    by_name = {item.name: item for item in api_pages.everything(items)}
    paths = {}
    for service in (item for item in items if item.kind == "service"):
        for method in service.items:
            if not method.proto.client_streaming and not method.proto.server_streaming:
                paths[f"/{service.name}/{method.short}"] = {"post": operation(service, method)}
    paths["/healthz"] = plain_get("Tells that the process runs")
    paths["/readyz"] = plain_get("Tells that the server takes calls", ("503", "The server is stopping."))
    paths["/metrics"] = plain_get("Counters and gauges for Prometheus", ("default", "The token does not reach all sheets."))
    schemas = {"google.rpc.Status": STATUS}
    waiting = list(references(paths))
    while waiting:
        name = waiting.pop()
        if name in schemas:
            continue
        item = by_name.get(name)
        schemas[name] = FOREIGN[name] if item is None else (schema_of_enum if item.kind == "enum" else schema_of_message)(item)
        waiting += references(schemas[name])
    version = re.search(r"project\(kerf VERSION (\S+)", (api_pages.ROOT / "CMakeLists.txt").read_text()).group(1)
    return {
        "openapi": "3.1.0",
        "info": {"title": "Kerf", "version": version, "license": {"name": "Apache 2.0", "identifier": "Apache-2.0"},
                 "description": "The JSON calls of a Kerf server: every call of kerf.v1 that is no stream. Field names are those of the .proto files."},
        "servers": [{"url": "/"}],
        "security": [{}, {"token": []}],
        "tags": [{"name": service.short, "description": prose(service.comment)} for service in items if service.kind == "service"
                 and any(path.startswith(f"/{service.name}/") for path in paths)] + [{"name": "Server", "description": "State of the process."}],
        "paths": dict(sorted(paths.items())),
        "components": {"schemas": dict(sorted(schemas.items())),
                       "securitySchemes": {"token": {"type": "http", "scheme": "bearer", "description": "For servers with --tokens."}}}}


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    pathlib.Path(sys.argv[1]).write_text(json.dumps(document(), indent=1) + "\n")
