"""What the program is built from: crates, and what else ends up in it, with licences and where their texts are."""

from __future__ import annotations

import gzip
import html
import json
import os
import re
import subprocess
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

#: The root of the repository.
REPOSITORY = Path(__file__).resolve().parent.parent

#: The names of files with licences and notices.
NOTICE = re.compile(r"(un)?licen[cs]e|copying|copyright|notice", re.IGNORECASE)

#: Folders of a crate whose files are not part of a program that uses it.
ASIDE = {"tests", "test", "examples", "benches", "fuzz", "docs", "target"}

#: The files of this repository with texts of licences, for crates that come without their own. The text of the Apache
#: licence holds no name of an author. That of MIT does: it is given the authors that the crate names.
STANDARD = {"Apache-2.0": "LICENSE-APACHE", "MIT": "LICENSE-MIT"}

#: The version of the fonts that are in the program.
DEJAVU = "2.37"

#: The names of notices of work that a crate took over from others, such as COPYING.LAPACK.BSD.
TAKEN_OVER = re.compile(r".*\.[A-Z][A-Z0-9_]*\.[A-Z][A-Z0-9]*")


class PackagingError(Exception):
    """Something that must be corrected before the program can be passed on."""


@dataclass
class Part:
    """A crate, or something else that is in the program."""

    name: str
    version: str
    licence: str
    #: The identifier in lists of parts: a package URL.
    url: str
    #: The text of each licence and notice, by the name of its file.
    texts: dict[str, str] = field(default_factory=dict)


def run(*command: str) -> str:
    """What a command prints."""
    return subprocess.run(command, check=True, cwd=REPOSITORY, stdout=subprocess.PIPE, text=True).stdout


def epoch() -> int:
    """The time of what is packed, in seconds since 1970: SOURCE_DATE_EPOCH."""
    text = os.environ.get("SOURCE_DATE_EPOCH")
    example = "for example SOURCE_DATE_EPOCH=$(git log -1 --format=%ct), as the Makefile does"
    if text is None:
        raise PackagingError(f"SOURCE_DATE_EPOCH is not set; set it to the time of what is packed, {example}")
    if not re.fullmatch("[0-9]+", text):
        raise PackagingError(f"SOURCE_DATE_EPOCH is {text!r}, and must be whole seconds since 1970, {example}")
    return int(text)


def version() -> str:
    """The version of the program."""
    [program] = [package for package in metadata("--no-deps")["packages"] if package["name"] == "stickslip"]
    return program["version"]


def crates(bill: dict[str, Any], target: str) -> list[Part]:
    """The crates of a bill of materials for a target that others made."""
    listed = metadata("--filter-platform", target)["packages"]
    packages = {(package["name"], package["version"]): package for package in listed}
    found = []
    for component in bill["components"]:
        package = packages[component["name"], component["version"]]
        # What has no source lies in the repository, and is under the licences of the program.
        if package["source"] is not None:
            [licence] = component["licenses"]
            part = Part(component["name"], component["version"], licence["expression"], component["purl"])
            part.texts = notices(Path(package["manifest_path"]).parent)
            if all(TAKEN_OVER.fullmatch(name) for name in part.texts):
                part.texts |= _standard(part, package["authors"])
            found.append(part)
    return sorted(found, key=lambda part: (part.name, part.version))


def embedded() -> list[Part]:
    """What the crates of the program carry that others made."""
    report = REPOSITORY / "crates" / "runner" / "src" / "report"
    script = gzip.decompress((report / "plotly-cartesian.min.js.gz").read_bytes())[:400].decode()
    plotly = re.search(r"plotly\.js .* v([0-9.]+)", script)
    if plotly is None:
        raise PackagingError("the head of plotly-cartesian.min.js.gz names no version")
    texts = {"LICENSE": _text(report / "plotly-license.txt")}
    parts = [Part("plotly.js", plotly[1], "MIT", f"pkg:npm/plotly.js@{plotly[1]}", texts)]
    fonts = REPOSITORY / "crates" / "runner" / "src" / "plot" / "font"
    texts = {"LICENSE": _text(fonts / "dejavu-license.txt")}
    parts.append(Part("DejaVu fonts", DEJAVU, "Bitstream-Vera", f"pkg:generic/dejavu-fonts@{DEJAVU}", texts))
    return parts


def toolchain() -> list[Part]:
    """What the compiler and the linker add to every program. Zig, which links, is a package of this Python."""
    import ziglang  # type: ignore[import-not-found]

    compiler = re.search(r"^release: (.*)$", run("rustc", "--version", "--verbose"), re.MULTILINE)
    if compiler is None:
        raise PackagingError("rustc names no release")
    page = Path(run("rustc", "--print", "sysroot").strip()) / "share" / "doc" / "rust" / "COPYRIGHT-library.html"
    zig = Path(ziglang.__file__).parent
    linker = run(str(zig / "zig"), "version").strip()
    library = zig / "lib"

    def of_zig(name: str, licence: str, file: Path) -> Part:
        return Part(name, f"of Zig {linker}", licence, f"pkg:generic/{name}?from=zig%40{linker}", {file.name: _text(file)})

    return [
        Part(
            "rust-std",
            compiler[1],
            "MIT OR Apache-2.0",
            f"pkg:generic/rust-std@{compiler[1]}",
            _texts_of_page(page.read_text(encoding="utf-8")),
        ),
        of_zig("compiler_rt", "MIT", zig / "LICENSE"),
        of_zig("libunwind", "Apache-2.0 WITH LLVM-exception", library / "libunwind" / "LICENSE.TXT"),
        of_zig("glibc-start-files", "LGPL-2.1-or-later", library / "libc" / "glibc" / "LICENSES"),
    ]


def metadata(*options: str) -> dict[str, Any]:
    """What cargo says of the packages."""
    cargo = os.environ.get("CARGO", "cargo")
    return json.loads(run(cargo, "metadata", "--locked", "--format-version", "1", *options))


def notices(folder: Path) -> dict[str, str]:
    """The texts of licences and notices in the folder of a crate."""
    texts = {}
    for place, folders, files in os.walk(folder):
        folders[:] = sorted(set(folders) - ASIDE)
        is_of_licences = re.fullmatch(r"licen[cs]es?", Path(place).name, re.IGNORECASE)
        for name in sorted(files):
            path = Path(place, name)
            if (NOTICE.match(name) or is_of_licences) and path.suffix.lower() in {"", ".txt", ".md"} | _suffixes(name):
                texts[path.relative_to(folder).as_posix()] = _text(path)
    return texts


def _suffixes(name: str) -> set[str]:
    """What stands behind the last dot of a name such as LICENSE-Apache-2.0 or COPYING.LAPACK.BSD, where it is none of a kind
    of file."""
    suffix = Path(name).suffix
    return {suffix.lower()} if re.match(r"\.[0-9]", suffix) or TAKEN_OVER.fullmatch(name) else set()


def _standard(part: Part, authors: list[str]) -> dict[str, str]:
    """The text of a licence for a crate that brings none, if it lets itself be passed on under one of `STANDARD`."""
    choices = re.split(r"\s+OR\s+", part.licence.strip("()"))
    holders = ", ".join(authors) or f"the authors of {part.name}"
    for licence, file in STANDARD.items():
        if licence in choices:
            text = _text(REPOSITORY / file)
            return {licence: re.sub(r"^Copyright \(c\).*$", f"Copyright (c) {holders}", text, flags=re.MULTILINE)}
    allowed = ", ".join(STANDARD)
    raise PackagingError(
        f"{part.name} {part.version} ({part.licence}) brings no text of its licence, and none of {allowed} applies"
    )


def _text(path: Path) -> str:
    return _tidy(path.read_bytes().decode("utf-8", errors="replace"))


def _tidy(text: str) -> str:
    """A text without what differs between copies of the same: ends of lines, and empty lines before and after it."""
    lines = [line.rstrip() for line in text.replace("\ufeff", "").splitlines()]
    return "\n".join(lines).strip("\n") + "\n"


def _texts_of_page(page: str) -> dict[str, str]:
    """The notices of Rust's standard library as plain text, and beside them each text that they hold."""
    texts: dict[str, str] = {}
    crate = ""

    def take(found: re.Match[str]) -> str:
        if found["crate"]:
            nonlocal crate
            crate = html.unescape(found["crate"]).strip("📦 ")
            return found[0]
        file, text = html.unescape(found["file"]), _tidy(html.unescape(found["text"]))
        texts[f"{crate}/{file}"] = text
        return f"<p>Text: {crate}/{file}</p>"

    block = (
        r"<h3>(?P<crate>.*?)</h3>"
        r"|<details>\s*<summary><code>(?P<file>.*?)</code></summary>\s*<pre>(?P<text>.*?)</pre>\s*</details>"
    )
    page = re.sub(r"<head>.*?</head>", "", page, flags=re.DOTALL)
    page = re.sub(block, take, page, flags=re.DOTALL)
    page = html.unescape(re.sub(r"<[^>]*>", "", page))
    lines = [line.strip() for line in page.splitlines()]
    overview = re.sub(r"\n{2,}", "\n", "\n".join(lines))
    return {"COPYRIGHT-library": _tidy(overview), **texts}
