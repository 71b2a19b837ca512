"""The base class of the parts of a Sheet."""

from __future__ import annotations

from typing import Any

from kerf.aio.connection import Connection


class SheetPart:
    """The base of classes with the methods of a sheet on one subject; Sheet inherits all of these."""

    def __init__(self, server: Connection, sheet_id: str) -> None:
        self._server = server
        self.id = sheet_id
        self.name = f"sheets/{sheet_id}"

    async def _call(self, method: Any, request: Any) -> Any:
        return await self._server.call(method, request)
