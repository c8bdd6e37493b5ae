"""The `pilotage` command. Each subcommand imports what it needs when it is called.

Bad arguments and unreadable input end with exit code 2 and one line that says what is wrong.
"""

import sys
import sysconfig
from enum import Enum
from pathlib import Path
from typing import Annotated

import typer

from pilotage import __version__
from pilotage.bus.deployment import ConfigError

BAD_INPUT = 2
FORCED = 130
DEMOS = (
    Path(__file__).resolve().parents[2] / "deploy" / "config" / "demo.yaml",
    Path(sysconfig.get_path("data")) / "share" / "pilotage" / "config" / "demo.yaml",
)
"""The demo of a checkout, and of an installed package."""


class Method(Enum):
    """How to localize: by the exact belief, by particles, by following walls."""

    markov = "markov"
    mcl = "mcl"
    ekf = "ekf"


class Spacing(Enum):
    """Where a topological map has its nodes: where features are, or evenly."""

    variable = "variable"
    equal = "equal"


class Sensor(Enum):
    """What `pilotage localize` weighs its belief by and `pilotage map` draws the map with."""

    laser = "laser"
    sonar = "sonar"


app = typer.Typer(
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    context_settings={"help_option_names": ["-h", "--help"]},
)


def _print_version(wanted: bool) -> None:  # noqa: FBT001 - the signature of an option's callback
    if wanted:
        sys.stdout.write(f"pilotage {__version__}\n")
        raise typer.Exit


@app.callback()
def _pilotage(
    _version: Annotated[  # noqa: FBT002 - how Typer declares an option
        bool,
        typer.Option(
            "--version", callback=_print_version, is_eager=True, help="Print the version and end."
        ),
    ] = False,
) -> None:
    """Tell a mobile robot where it is, from an unknown start, and say so when it is not known."""


@app.command()
def up(
    file: Annotated[
        Path | None, typer.Argument(help="Deployment; without one the demo.", show_default=False)
    ] = None,
    port: Annotated[
        int | None, typer.Option(min=1, max=65535, help="Port of the page.", show_default=False)
    ] = None,
    robot: Annotated[
        str | None, typer.Option(help="Name of the robot.", show_default=False)
    ] = None,
    endpoint: Annotated[
        str | None,
        typer.Option(help="Router to use or to start, tcp/HOST:PORT.", show_default=False),
    ] = None,
    browser: Annotated[bool, typer.Option(help="Open the page in a browser.")] = True,  # noqa: FBT002 - the same
) -> int:
    """Start and supervise every process of a deployment; Ctrl-C ends them all."""
    from pilotage.launcher.browser import open_page  # noqa: PLC0415 - see above
    from pilotage.launcher.effective import Overrides  # noqa: PLC0415 - see above
    from pilotage.launcher.run import launch  # noqa: PLC0415 - see above

    overrides = Overrides(robot=robot, endpoint=endpoint, port=port)
    show = open_page if browser else lambda _address: None
    return launch(file or _demo(), overrides, show)


@app.command()
def localize(  # noqa: PLR0913, PLR0917 - the options that design section 4 fixes
    log: Annotated[Path, typer.Argument(help="Recorded log, of any known format, .gz allowed.")],
    world: Annotated[Path, typer.Option("--map", help="Map: map_server YAML or Wean Hall.")],
    out: Annotated[Path, typer.Option(help="Folder for estimates.csv and report.json.")],
    start: Annotated[str, typer.Option(help="'unknown' or X,Y,THETA in m and rad.")] = "unknown",
    method: Annotated[Method, typer.Option(help="How to localize.")] = Method.markov,
    sensor: Annotated[Sensor, typer.Option(help="What weighs the belief.")] = Sensor.laser,
    compass: Annotated[bool, typer.Option(help="Use the log's compass.")] = True,  # noqa: FBT002 - the same
    log_format: Annotated[
        str | None, typer.Option("--format", help="Force a format.", show_default=False)
    ] = None,
) -> None:
    """Localize a robot over a recorded log, one estimate a scan."""
    from pilotage import localize_command as command  # noqa: PLC0415 - see above
    from pilotage.localizer.log_run import LogSensors  # noqa: PLC0415 - see above

    sensors = LogSensors(sensor=sensor.value, compass=compass)
    pose = command.parse_start(start)
    command.localize(
        command.LocalizeOptions(log, log_format, world, out, pose, sensors, method.value)
    )


@app.command(name="map")
def map_(  # noqa: PLR0913, PLR0917 - the options that design section 4 fixes
    log: Annotated[Path, typer.Argument(help="Recorded log, of any known format, .gz allowed.")],
    out: Annotated[Path, typer.Option(help="Folder for map, trajectory, picture and report.")],
    sensor: Annotated[
        Sensor | None,
        typer.Option(
            help="What draws the map; else what the log has, the laser first.", show_default=False
        ),
    ] = None,
    model: Annotated[
        str | None, typer.Option(help="Model of the sonar's cone.", show_default=False)
    ] = None,
    beams: Annotated[
        int | None,
        typer.Option(min=2, help="Use only so many of the laser's beams.", show_default=False),
    ] = None,
    log_format: Annotated[
        str | None, typer.Option("--format", help="Force a format.", show_default=False)
    ] = None,
) -> None:
    """Map the place that a recorded log went through."""
    from pilotage import map_command as command  # noqa: PLC0415 - see above

    options = command.MapOptions(log, log_format, out, sensor and sensor.value, beams, model)
    command.map_log(options)


@app.command()
def experiment(
    name: Annotated[str, typer.Argument(metavar="ID", help="Its name, or 'list'.")],
    out: Annotated[
        Path | None, typer.Option(help="Folder for report.json and plots.", show_default=False)
    ] = None,
    runs: Annotated[
        int | None, typer.Option(min=1, help="How often to repeat it.", show_default=False)
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="Of the random numbers.")] = 0,
) -> None:
    """Redo an experiment of the papers; 'list' names them."""
    from pilotage import experiment_command as command  # noqa: PLC0415 - see above

    if name == "list":
        command.list_experiments()
    else:
        command.run_experiment(command.ExperimentOptions(name, runs, seed, out))


@app.command()
def trial(  # noqa: PLR0913, PLR0917 - the options that design section 4 fixes
    world: Annotated[Path, typer.Option("--map", help="Map: map_server YAML or Wean Hall.")],
    policy: Annotated[str, typer.Option(help="How to go about: active, random, fixed or greedy.")],
    out: Annotated[Path, typer.Option(help="Folder for report.json and the tracks.")],
    runs: Annotated[int, typer.Option(min=1, help="From so many starts.")] = 20,
    seed: Annotated[int, typer.Option(min=0, help="Of starts and noise.")] = 0,
    sight: Annotated[
        float | None,
        typer.Option(
            min=0.5,
            max=100.0,
            help="How far the laser sees in m; else the farthest with ambiguous starts.",
            show_default=False,
        ),
    ] = None,
) -> None:
    """Drive a simulated robot on a map, from ambiguous starts, until it is localized."""
    from pilotage import trial_command as command  # noqa: PLC0415 - see above

    command.trial(command.TrialOptions(world, policy, runs, seed, out, sight))


@app.command()
def topology(
    world: Annotated[
        Path, typer.Argument(metavar="MAP", help="Map: map_server YAML or Wean Hall.")
    ],
    out: Annotated[Path, typer.Option(help="GeoJSON to write; a picture goes beside it.")],
    spacing: Annotated[
        Spacing, typer.Option(help="Nodes where features are, or evenly.")
    ] = Spacing.variable,
    distance: Annotated[
        float,
        typer.Option(
            min=0.5, max=100.0, help="m from node to node; what variable spacing fills holes by."
        ),
    ] = 4.0,
) -> None:
    """Make a topological map of a finished map: doors, passages, nodes and the ways between."""
    from pilotage import topology_command as command  # noqa: PLC0415 - see above

    command.topology(command.TopologyOptions(world, out, spacing.value, distance))


@app.command()
def bench(
    out: Annotated[Path, typer.Option(help="File for the list of figures, JSON.")],
) -> None:
    """Time the localizer beside plain numpy doing the same: two minutes."""
    from pilotage import bench_command  # noqa: PLC0415 - see above

    bench_command.bench(out)


driver_app = typer.Typer(help="Drivers of robots.")
app.add_typer(driver_app, name="driver")


@driver_app.callback(invoke_without_command=True)
def _driver(context: typer.Context) -> None:
    """Drivers of robots."""
    if context.invoked_subcommand is None:
        sys.stdout.write(f"{context.get_help()}\n")


@driver_app.command()
def check(
    spec: Annotated[
        str, typer.Argument(help="package.module:Class, or a deployment whose robot is meant.")
    ],
) -> int:
    """Try a driver: describe, sense, drive slowly forward for two seconds, stop."""
    from pilotage import driver_command  # noqa: PLC0415 - see above

    return driver_command.check(spec)


def _demo() -> Path:
    for path in DEMOS:
        if path.is_file():
            return path
    raise ConfigError(f"the demo is missing from {DEMOS[0].parent}: name a deployment file")


def main() -> None:
    """Run the command line and end the process with its exit code."""
    sys.exit(run(sys.argv[1:]))


def run(arguments: list[str]) -> int:
    """Run one command and return its exit code; errors in the input are told in one line."""
    try:
        code = app(arguments or ["--help"], prog_name="pilotage", standalone_mode=False)
    except typer.TyperException as error:
        return _complain(error.format_message(), BAD_INPUT)
    except ConfigError as error:
        return _complain(str(error), BAD_INPUT)
    except OSError as error:
        return _complain(_in_words(error), BAD_INPUT)
    except MemoryError as error:
        return _complain(f"this needs more memory than there is: {error}", BAD_INPUT)
    except typer.Abort:
        return _complain("interrupted", FORCED)
    return code if isinstance(code, int) else 0


def _in_words(error: OSError) -> str:
    """Return what the machine refused, without its number for it."""
    words = error.strerror or str(error)
    return words if error.filename is None else f"{error.filename}: {words}"


def _complain(reason: str, code: int) -> int:
    sys.stderr.write(f"pilotage: {' '.join(reason.split())}\n")
    return code
