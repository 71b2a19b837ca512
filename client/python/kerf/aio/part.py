"""The base class of the parts of a Sheet."""

from __future__ import annotations

from typing import Any

from kerf.aio.connection import Connection


class SheetPart:
    """The methods of a sheet that belong to one subject: Sheet is all of them."""

    def __init__(self, server: Connection, sheet_id: str) -> None:
        self._server = server
        self.id = sheet_id
        self.name = f"sheets/{sheet_id}"

    async def _call(self, method: Any, request: Any) -> Any:
        return await self._server.call(method, request)
