"""Tokens and TLS, against small servers that ask for them: what a connection sends, trusts and refuses to send."""

import asyncio
import concurrent.futures
import os
import pathlib
import unittest
import unittest.mock

import grpc
import kerf
import kerf.aio
from google.protobuf import any_pb2
from google.rpc import error_details_pb2, status_pb2
from kerf.credentials import is_on_this_machine
from kerf.v1 import (
    access_service_pb2,
    access_service_pb2_grpc,
    render_pb2,
    render_pb2_grpc,
    server_pb2,
    server_pb2_grpc,
    sheets_pb2,
    sheets_pb2_grpc,
    stream_pb2,
    stream_pb2_grpc,
)
from support import path
from test_authority import Authority

TOKEN = "kerf_laptop_0123456789"
VARIABLES = ("KERF_TOKEN_FILE", "KERF_TLS_CA", "KERF_TLS_CERT", "KERF_TLS_KEY", "SSL_CERT_FILE", "GRPC_DEFAULT_SSL_ROOTS_FILE_PATH")


def refusal(context, code, reason):
    """Ends a call as kerfd does."""
    detail = any_pb2.Any()
    detail.Pack(error_details_pb2.ErrorInfo(reason=reason, domain="kerf"))
    status = status_pb2.Status(code=code.value[0], message="no", details=[detail])
    context.set_trailing_metadata((("grpc-status-details-bin", status.SerializeToString()),))
    context.abort(code, "no")


class Asking(grpc.ServerInterceptor):
    """Notes who makes which call, and refuses all without the token."""

    def __init__(self):
        self.calls = []

    def intercept_service(self, continuation, details):
        authorization = [value for key, value in details.invocation_metadata if key == "authorization"]
        self.calls.append((details.method.rpartition("/")[2], authorization))
        handler = continuation(details)
        if authorization == [f"Bearer {TOKEN}"]:
            return handler
        reason = "TOKEN_UNKNOWN" if authorization else "TOKEN_MISSING"
        kind = {(False, False): grpc.unary_unary_rpc_method_handler, (False, True): grpc.unary_stream_rpc_method_handler,
                (True, False): grpc.stream_unary_rpc_method_handler, (True, True): grpc.stream_stream_rpc_method_handler}
        return kind[handler.request_streaming, handler.response_streaming](
            lambda _, context: refusal(context, grpc.StatusCode.UNAUTHENTICATED, reason),
            request_deserializer=handler.request_deserializer, response_serializer=handler.response_serializer)


class Access(access_service_pb2_grpc.AccessServiceServicer):
    def GetAccess(self, request, context):
        return access_service_pb2.Access(asks_for_tokens=True, token_id="laptop", scope=access_service_pb2.SCOPE_CUT, sheets="*")

    def CreateLink(self, request, context):
        if request.scope == access_service_pb2.SCOPE_ADMIN:
            refusal(context, grpc.StatusCode.PERMISSION_DENIED, "SCOPE_TOO_LOW")
        words = (request.sheet_id, request.scope, request.lifetime_s, request.once)
        return access_service_pb2.AccessLink(code="c", path="/#" + ",".join(map(str, words)))


class Server(server_pb2_grpc.ServerServiceServicer):
    def GetServerInfo(self, request, context):
        return server_pb2.ServerInfo(version="of a test")


class Sheets(sheets_pb2_grpc.SheetServiceServicer):
    def ReplayRecording(self, requests, context):
        return sheets_pb2.Sheet(name=f"sheets/{next(requests).start.sheet_id}")

    def GetSheetRecording(self, request, context):
        yield sheets_pb2.RecordingChunk(content=b"recorded")


class Streams(stream_pb2_grpc.StreamServiceServicer):
    def Watch(self, requests, context):
        yield stream_pb2.WatchResponse(ended=stream_pb2.Ended(reason=stream_pb2.Ended.SHEET_DELETED))

    def Subscribe(self, request, context):
        yield stream_pb2.WatchResponse(ended=stream_pb2.Ended(reason=stream_pb2.Ended.SHEET_DELETED))


class Pictures(render_pb2_grpc.RenderServiceServicer):
    def WatchImages(self, requests, context):
        yield render_pb2.WatchImagesResponse(ended=stream_pb2.Ended(reason=stream_pb2.Ended.SHEET_DELETED))


def start(asking, credentials=None):
    """Returns a server that asks for the token, and its port."""
    server = grpc.server(concurrent.futures.ThreadPoolExecutor(8), interceptors=(asking,))
    access_service_pb2_grpc.add_AccessServiceServicer_to_server(Access(), server)
    server_pb2_grpc.add_ServerServiceServicer_to_server(Server(), server)
    sheets_pb2_grpc.add_SheetServiceServicer_to_server(Sheets(), server)
    stream_pb2_grpc.add_StreamServiceServicer_to_server(Streams(), server)
    render_pb2_grpc.add_RenderServiceServicer_to_server(Pictures(), server)
    port = server.add_secure_port("127.0.0.1:0", credentials) if credentials else server.add_insecure_port("127.0.0.1:0")
    server.start()
    return server, port


def file_with(name, content):
    file = pathlib.Path(path(name))
    file.write_bytes(content)
    return file


class Case(unittest.TestCase):
    def setUp(self):
        environment = {key: value for key, value in os.environ.items() if key not in VARIABLES}
        patch = unittest.mock.patch.dict(os.environ, environment, clear=True)
        patch.start()
        self.addCleanup(patch.stop)
        self.asking = Asking()

    def serve(self, credentials=None):
        server, port = start(self.asking, credentials)
        self.addCleanup(server.stop, None)
        return f"127.0.0.1:{port}"


class Tokens(Case):
    def test_every_kind_of_call_carries_the_token(self):
        with kerf.connect(self.serve(), token_file=file_with("token", f"\n  {TOKEN} \r\n".encode())) as server:
            self.assertEqual(server.info().version, "of a test")
            self.assertEqual((server.access().token_id, server.access().sheets), ("laptop", "*"))
            recording = file_with("of-sheet.rec", b"recording")
            sheet = server.replay(recording, "again")
            self.assertEqual((sheet.name, sheet.record(path("fetched.rec"))), ("sheets/again", 8))
            for stream in (sheet.watch(), sheet.subscribe(), sheet.watch_images()):
                with self.assertRaises(kerf.NotFound):
                    next(stream)
        self.assert_all_carried("GetServerInfo", "GetAccess", "ReplayRecording", "GetSheetRecording", "Watch", "Subscribe", "WatchImages")

    def test_so_does_every_kind_of_asyncio(self):
        address = self.serve()

        async def work():
            async with kerf.aio.connect(address, token=TOKEN) as server:
                self.assertEqual((await server.info()).version, "of a test")
                self.assertEqual((await server.access()).scope, access_service_pb2.SCOPE_CUT)
                self.assertEqual((await server.create_link("demo")).path, "/#demo,1,0,False")
                sheet = await server.replay(file_with("of-sheet.rec", b"recording"), "again")
                self.assertEqual(await sheet.record(path("fetched.rec")), 8)
                for stream in (sheet.watch(), sheet.subscribe(), sheet.watch_images()):
                    with self.assertRaises(kerf.NotFound):
                        await stream.__anext__()

        asyncio.run(work())
        self.assert_all_carried("GetServerInfo", "GetAccess", "CreateLink", "ReplayRecording", "GetSheetRecording", "Watch", "Subscribe",
                                "WatchImages")

    def assert_all_carried(self, *methods):
        self.assertEqual({method for method, _ in self.asking.calls}, set(methods))
        for method, authorization in self.asking.calls:
            self.assertEqual(authorization, [f"Bearer {TOKEN}"], method)

    def test_metadata_of_a_caller_goes_with_it(self):
        with kerf.connect(self.serve(), token=TOKEN) as server:
            server.server_service.GetServerInfo(server_pb2.GetServerInfoRequest(), metadata=(("x-note", "mine"),), timeout=60)
        self.assert_all_carried("GetServerInfo")

    def test_a_caller_that_is_not_known_is_told_so(self):
        address = self.serve()
        for options, reason, message in (({}, "TOKEN_MISSING", "no; give it to connect() as token_file, or name its file in KERF_TOKEN_FILE"),
                                         ({"token": "kerf_other_1"}, "TOKEN_UNKNOWN", "no")):
            with kerf.connect(address, **options) as server:
                stream = server.sheet("demo").watch()
                for call in (server.info, lambda: server.sheet("demo").record(path("refused.rec")), lambda: next(stream)):
                    with self.assertRaises(kerf.Unauthenticated) as caught:
                        call()
                    error = caught.exception
                    self.assertEqual((error.code, error.reason, error.message), ("UNAUTHENTICATED", reason, message))

    def test_links_have_what_was_asked_for(self):
        with kerf.connect(self.serve(), token=TOKEN) as server:
            self.assertEqual(server.create_link().path, "/#,1,0,False")
            self.assertEqual(server.create_link("demo", scope="cut", lifetime_s=600, once=True).path, "/#demo,2,600,True")
            with self.assertRaises(kerf.PermissionDenied) as caught:
                server.create_link(scope="admin")
            self.assertEqual(caught.exception.reason, "SCOPE_TOO_LOW")
            with self.assertRaisesRegex(ValueError, "scope is 'all'; must be one of view, cut, admin"):
                server.create_link(scope="all")

    def test_a_token_of_the_environment_counts_unless_one_is_given(self):
        address = self.serve()
        os.environ["KERF_TOKEN_FILE"] = str(file_with("token", f"{TOKEN}\n".encode()))
        with kerf.connect(address) as server:
            server.info()
        with kerf.connect(address, token="kerf_other_1") as server, self.assertRaises(kerf.Unauthenticated):
            server.info()
        os.environ["KERF_TOKEN_FILE"] = ""
        with kerf.connect(address) as server, self.assertRaises(kerf.Unauthenticated):
            server.info()

    def test_unusable_tokens(self):
        missing = path("no-such-token")
        self.refused(OSError, r"token_file: No such file or directory", token_file=missing)
        self.refused(OSError, r"token_file: Is a directory", token_file=path("."))
        self.refused(ValueError, "^token_file: the token is empty", token_file=file_with("empty", b" \n"))
        self.refused(ValueError, "^token_file: there is more than one line", token_file=file_with("two", b"kerf_secret\nkerf_secret"))
        self.refused(ValueError, "^token_file: the token has characters", token_file=file_with("odd", b"kerf_secret\xc3\xa9"))
        self.refused(ValueError, "^token_file: .* has more than 4096 bytes", token_file="/dev/zero")
        self.refused(ValueError, "^token: the token is empty", token="")
        self.refused(ValueError, "not both", token="kerf_secret", token_file=missing)
        os.environ["KERF_TOKEN_FILE"] = missing
        self.refused(OSError, r"token_file \(KERF_TOKEN_FILE\): No such file")

    def refused(self, kind, words, address="127.0.0.1:1", **options):
        for connect in (kerf.connect, kerf.aio.connect):
            with self.assertRaisesRegex(kind, words) as caught:
                connect(address, **options)
            self.assertNotIn("secret", str(caught.exception))

    def test_a_token_leaves_this_machine_through_tls_alone(self):
        self.refused(ValueError, "^token: the token is not sent to kerf.example.org:50051 in the clear.*use TLS",
                     "kerf.example.org:50051", token="kerf_secret")
        kerf.connect("kerf.example.org:50051").close()
        kerf.connect("kerf.example.org:50051", token="kerf_secret", tls=True).close()

    def test_which_addresses_are_of_this_machine(self):
        for address in ("127.0.0.1:1", "127.9.8.7", "[::1]:1", "::1", "localhost:1", "LocalHost", "unix:/run/kerf", "unix-abstract:kerf",
                        "dns:///localhost:1", "ipv4:127.0.0.1:1,127.0.0.2:1", "ipv6:[::1]:1"):
            self.assertTrue(is_on_this_machine(address), address)
        for address in ("", "128.0.0.1:1", "0.0.0.0:1", "[::]:1", "[fe80::1]:1", "localhost.example.org:1", "127.0.0.1.example.org:1",
                        "dns://8.8.8.8/localhost:1", "ipv4:127.0.0.1:1,10.0.0.1:1", "ipv4:", "localhost:1,evil:2", "127.1:1", "[::1", "[127.0.0.1]evil"):
            self.assertFalse(is_on_this_machine(address), address)

    def test_no_secret_is_printed(self):
        secrets = kerf.credentials.Secrets("kerf_secret", True, b"a", b"b", b"kerf_secret")
        self.assertNotIn("kerf_secret", repr(secrets))


class Tls(Case):
    @classmethod
    def setUpClass(cls):
        cls.authority = Authority(path("authority"))
        cls.server_files = cls.authority.make("server")
        cls.client_files = cls.authority.make("client")

    def serve_tls(self, asks_for_certificates=False, files=None):
        certificate, key = (pathlib.Path(file).read_bytes() for file in files or self.server_files)
        authorities = pathlib.Path(self.authority.ca).read_bytes() if asks_for_certificates else None
        return self.serve(grpc.ssl_server_credentials([(key, certificate)], authorities, asks_for_certificates))

    def test_calls_are_encrypted_and_carry_the_token(self):
        address = self.serve_tls()
        with kerf.connect(address, token=TOKEN, tls_ca=self.authority.ca, timeout_s=60) as server:
            self.assertEqual(server.info().version, "of a test")
            with self.assertRaises(kerf.NotFound):
                next(server.sheet("demo").watch())

        async def work():
            async with kerf.aio.connect(address, token=TOKEN, tls_ca=self.authority.ca, timeout_s=60) as server:
                self.assertEqual((await server.info()).version, "of a test")

        asyncio.run(work())
        self.assertEqual([method for method, _ in self.asking.calls], ["GetServerInfo", "Watch", "GetServerInfo"])

    def test_authorities_of_the_system_count_without_others(self):
        address = self.serve_tls()
        self.no_tls(address, tls=True)
        os.environ["SSL_CERT_FILE"] = self.authority.ca
        with kerf.connect(address, token=TOKEN, tls=True, timeout_s=60) as server:
            server.info()

    def test_a_server_with_another_name_is_not_trusted(self):
        address = self.serve_tls(files=self.authority.make("elsewhere", "DNS:kerf.example.org"))
        self.no_tls(address, tls_ca=self.authority.ca)

    def test_a_server_without_tls_gets_no_token(self):
        self.no_tls(self.serve(), tls_ca=self.authority.ca)

    def no_tls(self, address, **options):
        with kerf.connect(address, token=TOKEN, timeout_s=60, **options) as server:
            with self.assertRaisesRegex(kerf.Unavailable, "TLS with the server failed: its certificate is") as caught:
                server.info()
        self.assertEqual((caught.exception.reason, self.asking.calls), ("TLS_FAILED", []))

    def test_a_server_that_asks_for_certificates_gets_one(self):
        address = self.serve_tls(asks_for_certificates=True)
        for options in ({"tls_ca": self.authority.ca}, {}):
            with kerf.connect(address, token=TOKEN, timeout_s=60, **options) as server:
                with self.assertRaisesRegex(kerf.Unavailable, "a server that asks for TLS, or for a certificate, closes"):
                    server.info()
        os.environ.update(KERF_TLS_CA=self.authority.ca, KERF_TLS_CERT=self.client_files[0], KERF_TLS_KEY=self.client_files[1])
        with kerf.connect(address, token=TOKEN, timeout_s=60) as server:
            server.info()

    def test_unusable_files(self):
        certificate, key = self.client_files
        for kind, words, options in (
                (ValueError, r"^tls_key \(KERF_TLS_KEY\): a certificate is given without its key", {"tls_cert": certificate}),
                (ValueError, r"^tls_cert \(KERF_TLS_CERT\): a key is given without its certificate", {"tls_key": key}),
                (OSError, "tls_ca: No such file", {"tls_ca": path("no-such-ca")}),
                (ValueError, "^tls_ca: .* has no CERTIFICATE in the form of PEM", {"tls_ca": key}),
                (ValueError, "^tls_key: .* has no PRIVATE KEY in the form of PEM", {"tls_cert": certificate, "tls_key": certificate}),
                (ValueError, "^tls_key: .* is encrypted", {
                    "tls_cert": certificate, "tls_key": file_with("locked", b"-----BEGIN ENCRYPTED PRIVATE KEY-----\n")})):
            with self.assertRaisesRegex(kind, words):
                kerf.connect("127.0.0.1:1", **options)
