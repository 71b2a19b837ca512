"""A small grpcurl: asks a server by reflection what it serves, and calls it by the answer. No generated code of Kerf takes part,
so calls that work here work for grpcurl. The protocol is grpc.reflection.v1alpha, given by its descriptors."""

import grpc
from google.protobuf import descriptor_pb2, descriptor_pool, json_format, message_factory

_FIELD = descriptor_pb2.FieldDescriptorProto
_PACKAGE = "grpc.reflection.v1alpha"
_METHOD = f"/{_PACKAGE}.ServerReflection/ServerReflectionInfo"


def _protocol():
    """The request and response classes, with the fields that are used here."""
    file = descriptor_pb2.FileDescriptorProto(name="reflection.proto", package=_PACKAGE, syntax="proto3")

    def add(name, *fields):
        message = file.message_type.add(name=name)
        for field, number, kind, label, type_name in fields:
            message.field.add(name=field, number=number, type=kind, label=label,
                              type_name=type_name and f".{_PACKAGE}.{type_name}")

    one, many = _FIELD.LABEL_OPTIONAL, _FIELD.LABEL_REPEATED
    add("ServerReflectionRequest", ("file_containing_symbol", 4, _FIELD.TYPE_STRING, one, None),
        ("list_services", 7, _FIELD.TYPE_STRING, one, None))
    file.message_type[0].oneof_decl.add(name="message_request")
    for field in file.message_type[0].field:
        field.oneof_index = 0
    add("FileDescriptorResponse", ("file_descriptor_proto", 1, _FIELD.TYPE_BYTES, many, None))
    add("ServiceResponse", ("name", 1, _FIELD.TYPE_STRING, one, None))
    add("ListServiceResponse", ("service", 1, _FIELD.TYPE_MESSAGE, many, "ServiceResponse"))
    add("ErrorResponse", ("error_code", 1, _FIELD.TYPE_INT32, one, None), ("error_message", 2, _FIELD.TYPE_STRING, one, None))
    add("ServerReflectionResponse",
        ("file_descriptor_response", 4, _FIELD.TYPE_MESSAGE, one, "FileDescriptorResponse"),
        ("list_services_response", 6, _FIELD.TYPE_MESSAGE, one, "ListServiceResponse"),
        ("error_response", 7, _FIELD.TYPE_MESSAGE, one, "ErrorResponse"))
    pool = descriptor_pool.DescriptorPool()
    pool.Add(file)
    return [_class_of(pool.FindMessageTypeByName(f"{_PACKAGE}.ServerReflection{end}")) for end in ("Request", "Response")]


def _class_of(descriptor):
    return message_factory.MessageFactory(descriptor.file.pool).GetPrototype(descriptor)


class Reflection:
    """A server as it describes itself. `address`: HOST:PORT."""

    def __init__(self, address):
        self.channel = grpc.insecure_channel(address, options=[("grpc.enable_http_proxy", 0)])
        self.request_class, self.response_class = _protocol()
        self.pool = descriptor_pool.DescriptorPool()

    def close(self):
        self.channel.close()

    def _ask(self, **what):
        ask = self.channel.stream_stream(_METHOD, request_serializer=self.request_class.SerializeToString,
                                         response_deserializer=self.response_class.FromString)
        answer = next(iter(ask(iter([self.request_class(**what)]), timeout=30)))
        if answer.HasField("error_response"):
            raise LookupError(answer.error_response.error_message)
        return answer

    def list(self):
        """Names of the services."""
        return [service.name for service in self._ask(list_services="*").list_services_response.service]

    def describe(self, symbol):
        """The descriptor of a service or a message. LookupError where the server knows none."""
        files = [descriptor_pb2.FileDescriptorProto.FromString(each) for each in
                 self._ask(file_containing_symbol=symbol).file_descriptor_response.file_descriptor_proto]
        known = {file.name: file for file in files}

        def add(name):
            # Those that it builds on come first; a file may be known from an earlier question.
            try:
                self.pool.FindFileByName(name)
            except KeyError:
                for below in known[name].dependency:
                    add(below)
                self.pool.Add(known[name])

        for file in files:
            add(file.name)
        try:
            return self.pool.FindServiceByName(symbol)
        except KeyError:
            return self.pool.FindMessageTypeByName(symbol)

    def call(self, method, request):
        """Calls PACKAGE.Service/Method with a request of plain values; the answers, one unless the method streams them."""
        service, name = method.split("/")
        described = self.describe(service).methods_by_name[name]
        message = json_format.ParseDict(request, _class_of(described.input_type)())
        call = self.channel.unary_stream("/" + method, request_serializer=type(message).SerializeToString,
                                         response_deserializer=_class_of(described.output_type).FromString)
        return [json_format.MessageToDict(answer, preserving_proto_field_name=True) for answer in call(message, timeout=30)]
