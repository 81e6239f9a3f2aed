# SPDX-License-Identifier: BSD-3-Clause
"""Text, tables and figures as HTML. Text from files is escaped here and nowhere else."""
from __future__ import annotations

import html
import json
import math
from dataclasses import dataclass, field
from itertools import repeat

import numpy as np

from palette import number

MOST_ROWS = 200  # of a table; the rest is counted
MOST_FILES = 8  # of a provenance


class Markup(str):
    """HTML of this program, which a table takes as it is; texts of files in it are escaped."""


def escaped(value) -> str:
    return html.escape(str(value), quote=True)


def shown(value, digits: int = 4) -> str:
    """A number as text, or "–" if there is none."""
    if value is None or (isinstance(value, float) and not math.isfinite(value)):
        return "–"
    if 1e4 <= abs(value) < 1e7:  # without an exponent
        return f"{float(f'{value:.{digits}g}'):.0f}".replace("-", "\N{MINUS SIGN}")
    return number(value, digits)


def half_width(stderr, factor: float = 1.0):
    """Half width of the 95 % interval; None if there is no standard error."""
    return None if stderr is None else 1.96 * factor * stderr


def with_error(estimate: dict, factor: float = 1.0) -> str:
    """"1.2996 ± 0.0084" from `value` and `stderr` times a factor. The error is that of the 95 %
    interval; it has two digits, and the value has the same number of decimals."""
    if estimate["value"] is None:
        return "–"
    return " ± ".join(text for text in value_and_error(factor * estimate["value"],
                                                       half_width(estimate["stderr"], factor)) if text)


def value_and_error(value: float, width: float | None) -> tuple[str, str]:
    """Both as text, to the same decimal: the second digit of the error."""
    if width is None:
        return shown(value, 5), ""
    if not 1e-8 < width < 1e4:
        return shown(value, 5), shown(width, 2)
    decimals = max(0, 1 - math.floor(math.log10(width)))
    return tuple(f"{number:.{decimals}f}".replace("-", "\N{MINUS SIGN}") for number in (value, width))


def _in_table(value) -> str:
    """Writes numbers of up to seven digits in full and booleans as "yes" or "no"."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float) and 1e4 <= abs(value) < 1e7:
        return f"{value:.0f}".replace("-", "\N{MINUS SIGN}")
    return shown(value) if isinstance(value, float) or value is None else str(value)


def _is_number(value) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _cell(value, is_number: bool, tag: str = "td") -> str:
    attributes = ' class="number"' if is_number else ""
    attributes += ' scope="col"' if tag == "th" else ""
    text = value if isinstance(value, Markup) else escaped(_in_table(value))
    return f"<{tag}{attributes}>{text}</{tag}>"


def table(columns: list[str], rows: list, caption: str = "") -> str:
    """A table of at most MOST_ROWS rows of plain values; it states the number of omitted rows."""
    lines = ["<div class=\"scroll\" tabindex=\"0\"><table>"]
    of_numbers = [any(_is_number(row[place]) for row in rows)
                  and all(_is_number(row[place]) or row[place] is None for row in rows)
                  for place in range(len(columns))]
    if caption:
        lines.append(f"<caption>{escaped(caption)}</caption>")
    lines.append("<thead><tr>" + "".join(map(_cell, columns, of_numbers, repeat("th"))) + "</tr></thead>")
    lines.append("<tbody>")
    for row in rows[:MOST_ROWS]:
        lines.append("<tr>" + "".join(_cell(value, is_number or _is_number(value))
                                        for value, is_number in zip(row, of_numbers)) + "</tr>")
    lines.append("</tbody></table></div>")
    if len(rows) > MOST_ROWS:
        lines.append(f"<p class=\"note\">{len(rows) - MOST_ROWS} more rows are not shown.</p>")
    return "\n".join(lines)


def facts(rows: list) -> str:
    """A table of names and values without a head."""
    lines = [f"<tr><th scope=\"row\">{escaped(name)}</th><td>{escaped(_in_table(value))}</td></tr>"
             for name, value in rows]
    return f"<table class=\"facts-table\"><tbody>{''.join(lines)}</tbody></table>"


def provenance_rows(content: dict) -> list[list]:
    """Names and texts; empty if an older culm wrote the document."""
    known = content.get("provenance")
    if not known:
        return []
    ranks = f"{known['ranks']} rank{'' if known['ranks'] == 1 else 's'}"
    rows = [["command", known["command"]],
            ["written by", f"{known['version']}, {known['date'].replace('T', ' ').rstrip('Z')} UTC"],
            ["time", f"{shown(known['wall_s'], 3)} s on {ranks}, {shown(known['processor_s'], 3)} s "
                     "of processor time"],
            ["build", f"{known['compiler']}, {known['build']}; {known['libraries']}"]]
    rows += [["input", f"{entry['file']}: {_size(entry)}"] for entry in known["inputs"][:MOST_FILES]]
    if len(known["inputs"]) > MOST_FILES:
        rows.append(["inputs", f"{len(known['inputs']) - MOST_FILES} more"])
    return rows


def _size(entry: dict) -> str:
    if entry["bytes"] is None:
        return "could not be read again"
    return f"{entry['bytes']} bytes, CRC-32 {entry['crc32']}"


def folded(summary: str, content: str) -> str:
    """Content that opens on demand, by mouse or keyboard."""
    return f"<details><summary>{escaped(summary)}</summary>\n{content}\n</details>"


def _plain_data(value):
    """Arrays as lists, floats with seven digits, null where there is no number."""
    if isinstance(value, np.ma.MaskedArray):
        value = value.filled(np.nan)
    if isinstance(value, np.ndarray):
        value = value.tolist()
    if isinstance(value, dict):
        return {key: _plain_data(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain_data(item) for item in value]
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, float):
        if not math.isfinite(value):
            return None
        short = float(f"{value:.7g}")
        return int(short) if short == int(short) and abs(short) < 1e15 else short
    return value


def embedded_json(value) -> str:
    """JSON in which no text can end the enclosing script element."""
    text = json.dumps(_plain_data(value), ensure_ascii=False, separators=(",", ":"))
    return text.replace("<", "\\u003c").replace("\u2028", "\\u2028").replace("\u2029", "\\u2029")


def data_script(value, kind: str) -> str:
    return f"<script type=\"application/json\" class=\"{kind}\">{embedded_json(value)}</script>"


def _legend(entries: tuple) -> str:
    if not entries:
        return ""
    items = "".join("<li>" + ("<span style=\"color:{}\">●</span>" if kind == "dots" else
                              "<span class=\"line\" style=\"border-top:2px {1} {0}\"></span>")
                    .format(colour, kind) + f"{escaped(name)}</li>" for name, colour, kind in entries)
    return f"<ul class=\"legend\">{items}</ul>\n"


@dataclass
class Plot:
    """One drawing: traces and layout in the format of figures.js."""

    name: str  # unique within its section
    title: str
    description: str  # read aloud instead of the drawing
    traces: list[dict]
    layout: dict
    height: int = 340


@dataclass
class Section:
    """A part of the page; `verdict` summarises it in a few sentences."""

    key: str
    title: str
    tone: str = "plain"  # "good", "doubt" or "plain"
    verdict: list[str] = field(default_factory=list)
    parts: list[str] = field(default_factory=list)

    def add(self, markup: str):
        self.parts.append(markup)

    def paragraph(self, text: str):
        self.parts.append(f"<p>{escaped(text)}</p>")

    def note(self, text: str):
        """A remark in small print."""
        self.parts.append(f"<p class=\"note\">{escaped(text)}</p>")

    def heading(self, text: str):
        self.parts.append(f"<h3>{escaped(text)}</h3>")

    def add_plots(self, plots: list[Plot], caption: str, behind: str = "", legend: tuple = ()):
        """A figure of one or more drawings; `behind` is the table of its numbers, `legend` the
        names, colours and kinds ("dots", or "solid" or "dashed" of a line) that its drawings share."""
        self.parts.append(self.figure(plots, caption, behind, legend))

    def figure(self, plots: list[Plot], caption: str, behind: str = "", legend: tuple = ()) -> str:
        cells = "\n".join(self.drawing(plot) for plot in plots)
        numbers = folded("Numbers behind this figure", behind) if behind else ""
        columns = 2 if len(plots) == 4 else min(len(plots), 3)
        return (f"<figure>\n{_legend(legend)}<div class=\"plots of-{columns}\">\n{cells}\n</div>\n"
                f"<figcaption>{escaped(caption)}</figcaption>\n{numbers}\n</figure>")

    def drawing(self, plot: Plot) -> str:
        title = f"<h4>{escaped(plot.title)}</h4>" if plot.title else ""
        return (f"<div class=\"cell\">{title}<div class=\"drawing\" id=\"{escaped(self.key)}-"
                f"{escaped(plot.name)}\" role=\"group\" aria-label=\"{escaped(plot.description)}\" "
                f"style=\"height:{plot.height}px\"></div>"
                f"{data_script({'data': plot.traces, 'layout': plot.layout}, 'plot-data')}</div>")

    def markup(self) -> str:
        sentences = "".join(f"<p>{escaped(sentence)}</p>" for sentence in self.verdict)
        content = "\n".join(self.parts)
        return (f"<section id=\"{escaped(self.key)}\" aria-labelledby=\"{escaped(self.key)}-title\">\n"
                f"<h2 id=\"{escaped(self.key)}-title\">{escaped(self.title)}</h2>\n"
                f"<div class=\"verdict {self.tone}\">{sentences}</div>\n{content}\n</section>")
