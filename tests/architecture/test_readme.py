"""What the READMEs tell people to type exists."""

import re
from pathlib import Path

from typer.core import TyperGroup
from typer.main import get_command

from architecture.source_tree import REPOSITORY, teach, written_files
from pilotage.cli import app

BLOCK = re.compile(r"```(?:sh|bash|console)\n(.*?)```|((?:^    \S.*\n)+)", re.DOTALL | re.MULTILINE)
LINK = re.compile(r"\[([^\]]*)\]\(([^)#\s]+)[^)]*\)")


def readmes() -> list[Path]:
    return [path for path in written_files() if path.name == "README.md"]


def commands(readme: Path) -> list[str]:
    """The lines of shell blocks, without comments and prompts."""
    text = readme.read_text(encoding="utf-8")
    blocks = [fenced or indented for fenced, indented in BLOCK.findall(text)]
    lines = [line.strip().removeprefix("$ ") for block in blocks for line in block.splitlines()]
    return [line.split("  #")[0].strip() for line in lines if line]


def test_every_script_a_readme_names_exists() -> None:
    teach(
        f"{readme.relative_to(REPOSITORY)}: '{command}' runs a file that is not there"
        for readme in readmes()
        for command in commands(readme)
        if command.startswith(("./", "deploy/")) and not (REPOSITORY / command.split()[0]).is_file()
    )


def pilotage_commands() -> list[tuple[Path, list[str]]]:
    """The words after `pilotage` of each command line, and the README it stands in."""
    found = [(readme, command.split()) for readme in readmes() for command in commands(readme)]
    return [(readme, words[1:]) for readme, words in found if words[:1] == ["pilotage"]]


def known_commands() -> dict[str, set[str]]:
    """Each command of the cli with its options."""
    group = get_command(app)
    assert isinstance(group, TyperGroup)
    return {
        name: {"--help"}
        | {option for parameter in command.params for option in parameter.opts}
        | {option for parameter in command.params for option in parameter.secondary_opts}
        for name, command in group.commands.items()
    }


def test_every_pilotage_command_of_a_readme_exists() -> None:
    known = known_commands()
    teach(
        f"{readme.relative_to(REPOSITORY)}: 'pilotage {words[0]}' is not a command; there are "
        f"{', '.join(sorted(known))}"
        for readme, words in pilotage_commands()
        if words and not words[0].startswith("-") and words[0] not in known
    )


def test_every_option_a_readme_uses_exists() -> None:
    known = known_commands()
    teach(
        f"{readme.relative_to(REPOSITORY)}: {word} is no option of 'pilotage {words[0]}'"
        for readme, words in pilotage_commands()
        for word in words[1:]
        if word.startswith("--") and words[0] in known and word not in known[words[0]]
    )


def test_every_link_between_files_leads_somewhere() -> None:
    teach(
        f"{readme.relative_to(REPOSITORY)}: [{text}]({target}) leads nowhere"
        for readme in readmes()
        for text, target in re.findall(
            r"\[([^\]]*)\]\(([^)#\s]+)[^)]*\)", readme.read_text("utf-8")
        )
        if "://" not in target and not (readme.parent / target).exists()
    )
