"""Messages of the program in the terms of this package: calls and arguments in place of commands and options."""

from __future__ import annotations

import re

#: The commands that are methods of a run, and those that are functions. The others exist at the command line alone.
_METHODS = frozenset({"resume", "verify", "plot", "report", "export", "status"})
_FUNCTIONS = frozenset({"check", "limit", "compare", "fit", "analyse", "trajectory"})

#: The options that are arguments of the same name, but for their dashes; those that take no value.
_ARGUMENTS = frozenset(
    "out overwrite samples seed threads cell sample of against result x y at target title columns probability confidence "
    "pointwise estimate plot format horizon start disc disc-modes grid allotment displacement job".split()
)
_FLAGS = frozenset({"overwrite", "pointwise"})

#: ``--set`` before what is set.
_SET = re.compile(r"(?<![\w-])--set[ =](?=.)")

#: An option, and behind it the name of its value, a number, or the last word of a command.
_OPTION = re.compile(r"(?<![\w-])--([a-z-]+)(?:( <[^>]*>)|[ =](?=\d)|[ =]([^ '<-][^ '<]*)$|)")


def in_python(text: str) -> str:
    """A message with calls for the commands between backticks, and arguments for options."""
    parts = text.split("`")
    return "`".join(remedy_in_python(part) if i % 2 else _with_arguments(part, False) for i, part in enumerate(parts))


def remedy_in_python(remedy: str) -> str:
    """A remedy, which is a command, an option or words."""
    return _call(remedy) or _with_arguments(remedy, True)


def _call(command: str) -> str | None:
    """The call in place of a command."""
    program, _, words = command.partition(" ")
    name, _, rest = words.partition(" ")
    if program != "stickslip":
        return None
    if not rest:
        run = "run"
    elif rest.startswith(("'", "$")):
        run = f"stickslip.Run({rest})"
    elif " " not in rest:
        run = f"stickslip.Run('{rest}')"
    else:
        return None
    if name in _METHODS:
        return f"{run}.{name}()"
    if name in _FUNCTIONS:
        return f"stickslip.{name}(...)"
    return "stickslip.run(...)" if name == "submit" else None


def _with_arguments(text: str, is_code: bool) -> str:
    """A text with arguments for options."""

    def argument(found: re.Match[str]) -> str:
        option, placeholder, word = found.groups()
        name, rest = option.replace("-", "_"), found[0][len("--" + option) :]
        if option not in _ARGUMENTS:
            return found[0]
        if placeholder:
            return name
        if option in _FLAGS:
            return f"{name}=True{rest}"
        if word and is_code:
            return f"{name}='{word}'"
        return f"{name}={rest if word else rest[1:]}"

    return _OPTION.sub(argument, _SET.sub("", text))
