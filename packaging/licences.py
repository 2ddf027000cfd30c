"""The licences of everything that is in the program, as one text."""

from __future__ import annotations

from parts import Part

HEAD = """\
stickslip contains work of others, under the licences below. First comes the list of what it contains, each with its
version, its licence as an SPDX expression, and the numbers of its texts; then the texts. What is the same text, word for
word, stands there once. stickslip itself is under LICENSE-MIT or LICENSE-APACHE, at your option.
"""


def third_party_licences(parts: list[Part]) -> str:
    """The list of parts, and the texts of their licences and notices."""
    numbers: dict[str, int] = {}
    entries = []
    for part in parts:
        lines = [f"{part.name} {part.version}", f"    licence: {part.licence}"]
        for file, text in part.texts.items():
            number = numbers.setdefault(text, len(numbers) + 1)
            lines.append(f"    {file}: text {number}")
        entries.append("\n".join(lines) + "\n")
    rule = "=" * 120
    texts = [f"{rule}\nText {number}\n{rule}\n\n{text}" for text, number in numbers.items()]
    return "\n".join([HEAD, *entries, *texts])
