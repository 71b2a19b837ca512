"""A connection to a server: its channel, its stubs and its unary calls."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Optional

from kerf import forks
from kerf.aio.transport import IS_ASYNC, call_unary, close_channel, open_channel
from kerf.credentials import Secrets
from kerf.v1 import (
    access_service_pb2_grpc,
    cuts_pb2_grpc,
    files_pb2_grpc,
    interaction_pb2_grpc,
    render_pb2_grpc,
    server_pb2_grpc,
    sheets_pb2_grpc,
    store_service_pb2_grpc,
    stream_pb2_grpc,
)

if TYPE_CHECKING:
    from typing_extensions import Self


class Connection:
    """The base class of Server. Sheets hold it, so that they need not import Server."""

    def __init__(self, address: str, *, timeout_s: Optional[float] = None, secrets: Secrets = Secrets()) -> None:
        self.address = address
        self.timeout_s = timeout_s  # time limit of later calls, seconds; None: no limit
        self._secrets = secrets
        self._open()
        self._watch_forks()

    def _open(self) -> None:
        """Opens the channel, in the child of a fork another one than the parent's."""
        self._channel = self._make_channel()
        channel = self._secrets.stub_channel(self._channel)
        # The generated stubs; call() calls those that have no method here.
        self.sheet_service = sheets_pb2_grpc.SheetServiceStub(channel)
        self.cut_service = cuts_pb2_grpc.CutServiceStub(channel)
        self.interaction_service = interaction_pb2_grpc.InteractionServiceStub(channel)
        self.render_service = render_pb2_grpc.RenderServiceStub(channel)
        self.stream_service = stream_pb2_grpc.StreamServiceStub(channel)
        self.server_service = server_pb2_grpc.ServerServiceStub(channel)
        self.access_service = access_service_pb2_grpc.AccessServiceStub(channel)
        self.file_service = files_pb2_grpc.FileServiceStub(channel)
        self.store_service = store_service_pb2_grpc.StoreServiceStub(channel)

    def _watch_forks(self) -> None:
        forks.watch(self, is_async=IS_ASYNC)

    def _make_channel(self) -> Any:
        return open_channel(self.address, self._secrets)

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(self, *_: object) -> None:
        await self.aclose()

    async def aclose(self) -> None:
        """Ends all calls and streams of this connection."""
        await close_channel(self._channel)

    async def call(self, method: Any, request: Any) -> Any:
        """Calls a unary method of a stub. Raises kerf.Error if the server refuses.

        >>> from kerf.v1 import server_pb2
        >>> (await server.call(server.server_service.GetServerInfo, server_pb2.GetServerInfoRequest())).workers > 0
        True
        """
        return await call_unary(method, request, self.timeout_s, self.address)
