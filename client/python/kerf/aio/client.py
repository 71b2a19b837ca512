"""A server and its sheets."""

from __future__ import annotations

import contextlib
import os
import pathlib
import secrets
from collections.abc import AsyncIterator, Iterable
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, Any, List, Literal, Optional

from kerf.aio.connection import Connection
from kerf.aio.sheet import Sheet
from kerf.aio.transport import call_sending
from kerf.credentials import FilePath, read_secrets
from kerf.errors import NotFound
from kerf.files import chunks_of
from kerf.links import scope_value
from kerf.probes import AnyProbe
from kerf.scenes import AnyScene, SheetOptions, as_scene, scene_with, take_large_mesh
from kerf.steps import Stepped, stepped_of, steps_request
from kerf.v1 import access_service_pb2, files_pb2, geometry_pb2, server_pb2, sheets_pb2, store_service_pb2

if TYPE_CHECKING:
    from typing_extensions import Unpack


def connect(
    address: str = "127.0.0.1:50051",
    *,
    timeout_s: Optional[float] = None,
    token: Optional[str] = None,
    token_file: Optional[FilePath] = None,
    tls: bool = False,
    tls_ca: Optional[FilePath] = None,
    tls_cert: Optional[FilePath] = None,
    tls_key: Optional[FilePath] = None,
) -> Server:
    """Returns a server by its gRPC address; use it in a `with`, or close it. The server is not contacted yet.

    timeout_s: seconds after which a call raises DeadlineExceeded; None: no limit. It does not apply to streams.

    token, token_file: what the server's tokens are checked against, or the path of a file with one line, the token.
    tls: encrypts the calls, as do tls_ca and tls_cert. tls_ca: path of a PEM file, the authorities to trust; None: those
    of the system. tls_cert, tls_key: paths of PEM files, the certificate to show and its key. Paths that are None are
    taken from the environment: KERF_TOKEN_FILE, KERF_TLS_CA, KERF_TLS_CERT, KERF_TLS_KEY. Raises OSError if a file
    cannot be read. Raises ValueError if its content is unusable, a certificate has no key, or a token would leave
    this machine without TLS.

    >>> async with kerf.aio.connect(address) as server:
    ...     (await server.info()).limits.max_sheets
    64
    """
    secrets = read_secrets(
        address, token=token, token_file=token_file, tls=tls, tls_ca=tls_ca, tls_cert=tls_cert, tls_key=tls_key
    )
    return Server(address, timeout_s=timeout_s, secrets=secrets)


class Server(Connection):
    """A server; made by connect()."""

    def __repr__(self) -> str:
        return f"<kerf.Server {self.address}>"

    async def info(self) -> server_pb2.ServerInfo:
        """Version, renderer, limits, material presets.

        >>> "silk" in (await server.info()).material_presets
        True
        """
        return await self.call(self.server_service.GetServerInfo, server_pb2.GetServerInfoRequest())

    async def inspect_drawing(self, drawing: geometry_pb2.Curve) -> files_pb2.DrawingReport:
        """Says what is in a drawing that kerf.svg() or kerf.dxf() made: its size, colours, layers and what would be cut.

        >>> report = await server.inspect_drawing(kerf.svg('<svg><circle r="40" stroke="red"/></svg>'))
        >>> report.lines, report.groups[0].selector
        (1, 'stroke=red')
        """
        request = files_pb2.InspectDrawingRequest()
        if drawing.HasField("dxf"):
            request.dxf.CopyFrom(drawing.dxf)
        else:
            request.svg.CopyFrom(drawing.svg)
        return await self.call(self.file_service.InspectDrawing, request)

    async def access(self) -> access_service_pb2.Access:
        """Says what the caller may do: scope, sheets and the end of the token. `asks_for_tokens` is False if the server asks
        for none, and everybody may do everything. Raises Unauthenticated if the token is missing, unknown or over.
        """
        return await self.call(self.access_service.GetAccess, access_service_pb2.GetAccessRequest())

    async def create_link(
        self,
        sheet_id: str = "",
        *,
        scope: Literal["view", "cut", "admin"] = "view",
        lifetime_s: int = 0,
        once: bool = False,
    ) -> access_service_pb2.AccessLink:
        """Makes a link that logs in whoever opens the viewer with it: the viewer's address and, after it, `path`.

        sheet_id: the one sheet that it reaches; empty: those of the caller. scope: at most that of the caller.
        lifetime_s: for how long logins last, 60..604,800; 0: 8 hours. once: it opens once, within 60 s. Raises
        FailedPrecondition: NO_TOKENS if the server asks for no token, PermissionDenied if the link could do more than
        the caller, InvalidArgument, and ResourceExhausted if there are 1,024.
        """
        request = access_service_pb2.CreateLinkRequest(
            scope=scope_value(scope), sheet_id=sheet_id, lifetime_s=lifetime_s, once=once
        )
        return await self.call(self.access_service.CreateLink, request)

    async def store_info(self) -> store_service_pb2.StoreInfo:
        """Counts what the server keeps in its data folder, and names the sheets that were set aside, with the reasons,
        and the backups. Raises FailedPrecondition if it keeps nothing.
        """
        return await self.call(self.store_service.GetStoreInfo, store_service_pb2.GetStoreInfoRequest())

    async def prune_store(self) -> store_service_pb2.PruneStoreResponse:
        """Removes old answers and what deleted sheets have left from the store, as the server does by itself now and
        then. Raises FailedPrecondition if it keeps nothing.
        """
        return await self.call(self.store_service.PruneStore, store_service_pb2.PruneStoreRequest())

    async def delete_set_aside(self, number: int) -> None:
        """Deletes a sheet that was set aside, for good; `store_info().set_aside` has the numbers. Raises NotFound if
        there is none of this number, and FailedPrecondition if the server keeps nothing.
        """
        await self.call(self.store_service.DeleteSetAsideSheet, store_service_pb2.DeleteSetAsideSheetRequest(number=number))

    async def backup_store(self, backup_id: str) -> store_service_pb2.StoreBackup:
        """Copies the store into a folder of this name, [a-z0-9][a-z0-9-]{0,62}, in the server's folder of backups. The
        server continues meanwhile. `kerfd --restore-store` makes a data folder of it.

        Raises AlreadyExists, ResourceExhausted (16 backups, another one under way, a full disk), and
        FailedPrecondition if the server keeps nothing.
        """
        request = store_service_pb2.BackupStoreRequest(backup_id=backup_id)
        return await self.call(self.store_service.BackupStore, request)

    def sheet(self, sheet_id: str) -> Sheet:
        """Returns an existing sheet by its id, without a call to the server.

        >>> server.sheet("demo")
        <kerf.Sheet sheets/demo>
        """
        return Sheet(self, sheet_id)

    async def sheets(self) -> List[Sheet]:
        """All sheets, by name.

        >>> sheet.id in [each.id for each in await server.sheets()]
        True
        """
        request = sheets_pb2.ListSheetsRequest(page_size=1000)
        found: List[Sheet] = []
        while True:
            page = await self.call(self.sheet_service.ListSheets, request)
            found += [Sheet(self, each.name.removeprefix("sheets/")) for each in page.sheets]
            if not page.next_page_token:
                return found
            request.page_token = page.next_page_token

    async def step(
        self,
        sheets: Iterable[Sheet],
        ticks: int = 1,
        *,
        state: bool = False,
        probes: Iterable[AnyProbe] = (),
    ) -> List[Stepped]:
        """Runs up to 256 paused sheets for exactly this many ticks each, side by side; returns when all are done, in the
        order of `sheets`.

        state, probes: as in Sheet.step(), for each sheet. If one cannot be stepped the call raises, and none is. One that
        fails on the way says so in Stepped.failure. Raises ResourceExhausted if the states exceed 64 MiB. Needs NumPy if
        states or probes are requested.

        >>> [stepped.state.positions.shape for stepped in await server.step([sheet], 5, state=True)]
        [(400, 3)]
        """
        request = steps_request([sheet.name for sheet in sheets], ticks, state, probes)
        return stepped_of(await self.call(self.sheet_service.StepSheets, request))

    async def create_sheet(self, sheet_id: str = "", **options: Unpack[SheetOptions]) -> Sheet:
        """Creates a sheet: a rectangle of grid[0] x grid[1] vertices, or the mesh of an .obj or .ply file. SheetOptions
        lists the options.

        sheet_id: [a-z][a-z0-9-]{0,62}; empty: the server chooses. create_scene() takes all else that a scene can
        have. Raises AlreadyExists, ResourceExhausted (the server's limit of sheets or vertices), and ValueError if
        the file's name has another ending. A mesh file of up to 64 MiB is sent in parts; the rest of a call may have
        up to 1 MiB.

        >>> flag = await server.create_sheet("flag", grid=(15, 10), size_m=(1.5, 1.0), pins=["left"], paused=True)
        >>> (await flag.get()).num_vertices
        150
        >>> await flag.delete()
        """
        return await self.create_scene(scene_with(options), sheet_id, paused=options.get("paused", False))

    async def create_scene(
        self, scene: AnyScene, sheet_id: str = "", *, paused: bool = False, request_id: str = ""
    ) -> Sheet:
        """Creates a sheet from a scene: a message, its JSON form as a dict, or the path of a scene file.

        Raises ValueError if the JSON is no scene. Files named in the scene are not read, and the server refuses
        them.

        >>> made = await server.create_scene({"grid": {"columns": 3, "rows": 4, "width_m": 1, "height_m": 2}}, "small")
        >>> await made.delete()
        """
        request = sheets_pb2.CreateSheetRequest(
            sheet_id=sheet_id, scene=as_scene(scene), paused=paused, request_id=request_id
        )
        if mesh := take_large_mesh(request.scene):
            start = sheets_pb2.SheetUpload(sheet=request, num_bytes=len(mesh))
            return await self._upload(self.sheet_service.UploadSheet, sheets_pb2.UploadSheetRequest, start, mesh)
        made = await self.call(self.sheet_service.CreateSheet, request)
        return Sheet(self, made.name.removeprefix("sheets/"))

    async def replay(self, path: "str | os.PathLike[str]", sheet_id: str = "", *, paused: bool = False) -> Sheet:
        """Creates a sheet that plays a recording made by Sheet.record() or `kerf run --record`: the same commands at
        the same ticks. The sheet takes no commands until the recording ends; (await sheet.get()).replay has its
        progress. At most 128 MiB.

        sheet_id: empty: the id in the recording; without one, the server chooses. Raises InvalidArgument with the
        offset at which the file is damaged, and OSError. A file that ends within an entry is played up to the entry
        before; replay.torn_bytes counts the rest.
        """
        content = pathlib.Path(path).read_bytes()
        start = sheets_pb2.RecordingUpload(sheet_id=sheet_id, paused=paused, num_bytes=len(content))
        method, request = self.sheet_service.ReplayRecording, sheets_pb2.ReplayRecordingRequest
        return await self._upload(method, request, start, content)

    async def _upload(self, method: Any, request: Any, start: Any, content: bytes) -> Sheet:
        """Creates a sheet from a file. request: the class of the call's messages, which are `start` and then chunks."""
        parts = [request(start=start), *(request(chunk=chunk) for chunk in chunks_of(content))]
        made = await call_sending(method, parts, self.timeout_s, self.address)
        return Sheet(self, made.name.removeprefix("sheets/"))

    @asynccontextmanager
    async def temporary_sheet(
        self, scene: Optional[AnyScene] = None, **options: Unpack[SheetOptions]
    ) -> AsyncIterator[Sheet]:
        """Creates a sheet with a unique name, and deletes it when the `with` is left, also by an exception.

        scene: as in create_scene(); with it, `paused` is the only other option allowed. Absent: the options are as
        in create_sheet().

        >>> async with server.temporary_sheet(grid=(8, 8), paused=True) as sheet:
        ...     (await sheet.cut(kerf.circle((0.5, 0.5), 0.2))).pieces
        2
        """
        if scene is not None and options.keys() - {"paused"}:
            raise TypeError(f"a scene is given: {min(options.keys() - {'paused'})!r} belongs in it")
        wanted = scene_with(options) if scene is None else scene
        name = f"temporary-{secrets.token_hex(6)}"
        sheet = await self.create_scene(wanted, name, paused=options.get("paused", False))
        try:
            yield sheet
        finally:
            with contextlib.suppress(NotFound):
                await sheet.delete()
