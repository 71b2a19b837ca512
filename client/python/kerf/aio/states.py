"""A sheet's saved states: saving one, going back to it."""

from __future__ import annotations

from typing import List

from kerf.aio.part import SheetPart
from kerf.v1 import sheets_pb2


class States(SheetPart):
    """Saved states."""

    async def save_state(
        self, state_id: str, *, overwrite: bool = False, request_id: str = ""
    ) -> sheets_pb2.SavedState:
        """Saves the state between two ticks under a name, [a-z][a-z0-9-]{0,62}, in the server's memory. It is lost when
        the sheet is deleted or the server stops.

        overwrite: replaces a state of this name; else AlreadyExists is raised. Raises ResourceExhausted beyond 16
        states of a sheet, or 256 MiB of states on the server. request_id: a repeat does nothing and gets the same
        answer.

        >>> (await sheet.save_state("before")).tick == (await sheet.get()).tick
        True
        """
        request = sheets_pb2.SaveStateRequest(
            parent=self.name, state_id=state_id, overwrite=overwrite, request_id=request_id
        )
        return await self._call(self._server.sheet_service.SaveState, request)

    async def restore_state(self, state_id: str, *, request_id: str = "") -> sheets_pb2.Sheet:
        """Brings a saved state back, bit for bit: mesh, motion, undo and redo, pins, grabs, settings, waiting cuts, list
        of cuts, recording, tick. The same commands at the same ticks then give the same hashes. Pause and speed stay
        as they are. Raises NotFound if there is no such state. undo() does not take it back.

        >>> saved = await sheet.save_state("before")
        >>> result = await sheet.cut(kerf.circle((0.5, 0.5), 0.2))
        >>> (await sheet.restore_state("before")).state_hash == saved.state_hash
        True
        """
        request = sheets_pb2.RestoreStateRequest(name=self._state_name(state_id), request_id=request_id)
        return await self._call(self._server.sheet_service.RestoreState, request)

    async def states(self) -> List[sheets_pb2.SavedState]:
        """Lists the saved states, those saved first at first.

        >>> saved = await sheet.save_state("before")
        >>> [state.name.rsplit("/")[-1] for state in await sheet.states()]
        ['before']
        """
        request = sheets_pb2.ListStatesRequest(parent=self.name)
        return list((await self._call(self._server.sheet_service.ListStates, request)).states)

    async def delete_state(self, state_id: str) -> None:
        """Deletes a saved state; the sheet stays as it is. Raises NotFound if there is no such state.

        >>> saved = await sheet.save_state("before")
        >>> await sheet.delete_state("before")
        """
        request = sheets_pb2.DeleteStateRequest(name=self._state_name(state_id))
        await self._call(self._server.sheet_service.DeleteState, request)

    def _state_name(self, state_id: str) -> str:
        return f"{self.name}/states/{state_id}"
