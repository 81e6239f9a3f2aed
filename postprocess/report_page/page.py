# SPDX-License-Identifier: BSD-3-Clause
"""Puts the sections together into one page that needs nothing but a browser."""
from __future__ import annotations

import base64
import hashlib
from pathlib import Path

from report_page.markup import Section, escaped

HERE = Path(__file__).resolve().parent
SCRIPTS = ("marks.js", "figures.js", "page.js")


def policy_for(scripts: list[str]) -> str:
    """The browser refuses whatever would need a network, and every script but these, which it knows
    by their hashes (CSP Level 2, section 4.2.5). A nonce would differ between two pages of the same
    files."""
    hashes = " ".join(f"'sha256-{_sha256(script)}'" for script in scripts)
    return (f"default-src 'none'; script-src {hashes}; "
            "style-src 'unsafe-inline'; img-src data: blob:; base-uri 'none'; form-action 'none'")


def _sha256(text: str) -> str:
    return base64.b64encode(hashlib.sha256(text.encode("utf-8")).digest()).decode("ascii")


def page_of(name: str, sections: list[Section], library: str, library_version: str) -> str:
    """The whole page; `library` is the source of D3."""
    style = (HERE / "page.css").read_text(encoding="utf-8")
    script = "".join((HERE / name).read_text(encoding="utf-8") for name in SCRIPTS)
    policy = policy_for([library, script])
    return f"""<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta http-equiv="Content-Security-Policy" content="{policy}">
<title>culm: {escaped(name)}</title>
<style>
{style}</style>
</head>
<body>
<a class="skip" href="#content">Skip to the results</a>
<header>
<h1>culm: {escaped(name)}</h1>
{_overview(sections)}
</header>
<noscript><p class="note">The figures need JavaScript; texts and tables do without.</p></noscript>
<main id="content">
{"".join(section.markup() for section in sections)}
</main>
<footer><p>Written by culm report; drawn with D3 {escaped(library_version)} (BSD-3-Clause), which
this page contains. Every number comes from the files in the folder.</p></footer>
<script>{library}</script>
<script>{script}</script>
</body>
</html>
"""


def _overview(sections: list[Section]) -> str:
    """The first words of every verdict, with links."""
    items = []
    for section in sections:
        first = section.verdict[0] if section.verdict else ""
        items.append(f"<li class=\"{section.tone}\"><a href=\"#{escaped(section.key)}\">"
                     f"{escaped(section.title)}</a>: {escaped(first)}</li>")
    return f"<nav aria-label=\"Results\"><ul>{''.join(items)}</ul></nav>"
