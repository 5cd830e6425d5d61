"""A fit as one HTML page: numbers, what is not told, pictures; it needs no other file.

In: the answer as plain data, pictures as PNG. Out: text. Names are escaped, never markup.
"""

import base64
from collections.abc import Sequence
from html import escape

from lamc.basics.numbers import shown_number
from lamc.fitting.answer import Fit
from lamc.fitting.compared import Compared
from lamc.report.fit_text import interval_text

_STYLE = (
    "body{font:15px/1.5 system-ui,sans-serif;max-width:60rem;margin:2rem auto;padding:0 1rem;color:#222}"
    "table{border-collapse:collapse;margin:1rem 0}"
    "td,th{padding:.25rem .8rem;border-bottom:1px solid #ddd;text-align:right}"
    "td:first-child,th:first-child{text-align:left}img{max-width:100%}.note{color:#8a4b00}"
)


def fit_page(title: str, fit: Fit, held: Sequence[Compared], pictures: Sequence[tuple[str, bytes]]) -> str:
    """pictures: (what it shows, PNG)."""
    rows = [
        (name, shown_number(fit.values[name], _unit(fit.units[name]), 6), interval_text(fit, name))
        for name in fit.names
    ]
    left = [
        (
            f"{each.name}{' (held back)' if each in held else ''}",
            column,
            shown_number(each.rms[column], each.units[k], 3),
            each.share_text(column),
        )
        for each in (*fit.compared, *held)
        for k, column in enumerate(each.columns)
    ]
    word = "converged" if fit.converged else "not converged"
    parts = [
        f"<h1>{escape(title)}</h1><p>{escape(word)}: {escape(fit.message)}; {fit.runs} runs; derivatives: "
        f"{escape(fit.derivatives)}.</p>",
        _table(("number", "value", "95 % interval"), rows),
        _list("What these data cannot tell", [str(each) for each in fit.unidentifiable]),
        _list("Notes", fit.notes),
        "<h2>Recordings</h2>",
        _table(("recording", "column", "left (rms)", "of its variance"), left),
    ]
    for what, picture in pictures:
        data = base64.b64encode(picture).decode("ascii")
        parts.append(f'<h2>{escape(what)}</h2><img alt="{escape(what)}" src="data:image/png;base64,{data}">')
    head = f'<meta charset="utf-8"><title>{escape(title)}</title><style>{_STYLE}</style>'
    return (
        f'<!doctype html>\n<html lang="en"><head>{head}</head><body>\n'
        + "\n".join(parts)
        + "\n</body></html>\n"
    )


def _unit(unit: str) -> str:
    return "" if unit == "1" else unit


def _table(heads: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    lines = ["<tr>" + "".join(f"<th>{escape(each)}</th>" for each in heads) + "</tr>"]
    lines += ["<tr>" + "".join(f"<td>{escape(each)}</td>" for each in row) + "</tr>" for row in rows]
    return "<table>" + "\n".join(lines) + "</table>"


def _list(title: str, lines: Sequence[str]) -> str:
    if not lines:
        return ""
    return (
        f'<h2>{escape(title)}</h2><ul class="note">'
        + "".join(f"<li>{escape(each)}</li>" for each in lines)
        + "</ul>"
    )
