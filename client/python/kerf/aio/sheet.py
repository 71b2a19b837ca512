"""One sheet of a server: cutting it, running it, pulling at it, looking at it."""

from __future__ import annotations

from kerf.aio.cutting import Cutting
from kerf.aio.interaction import Interaction
from kerf.aio.running import Running
from kerf.aio.states import States
from kerf.aio.transport import Shown
from kerf.aio.viewing import Viewing


class Sheet(Cutting, Running, States, Interaction, Viewing, Shown):
    """A sheet by its name. Every method is a call to the server and raises kerf.Error if the server refuses; a refusal
    changes nothing."""

    def __repr__(self) -> str:
        return f"<kerf.Sheet {self.name}>"
