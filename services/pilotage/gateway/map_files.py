"""The files of the map in use, each drawn once."""

import asyncio
from collections.abc import Callable

from pilotage_schemas.mapping import OccupancyGrid

Render = Callable[[OccupancyGrid], bytes]


class MapFiles:
    """Files of one map; they are forgotten when another comes.

    A large map takes tenths of a second to draw, so that happens in a thread.
    """

    def __init__(self) -> None:
        self._grid: OccupancyGrid | None = None
        self._files: dict[Render, asyncio.Task[bytes]] = {}

    async def get(self, grid: OccupancyGrid, render: Render) -> bytes:
        """Return `render(grid)`; who asks while it is drawn waits for the same drawing."""
        if grid is not self._grid:
            self._grid, self._files = grid, {}
        if render not in self._files:
            self._files[render] = asyncio.create_task(asyncio.to_thread(render, grid))
        return await asyncio.shield(self._files[render])
