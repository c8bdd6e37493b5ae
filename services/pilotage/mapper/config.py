"""Settings of the mapper."""

from pilotage.bus.deployment import ConfigPath, Settings


class MapperSettings(Settings):
    """Which map to serve.

    `map` is a map_server YAML file or the CMU Wean Hall map; without one the mapper waits for
    `load_map`.
    """

    map: ConfigPath | None = None
