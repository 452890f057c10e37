"""The report as one HTML page that needs nothing beside it: style and figures are inside."""

import base64
import re
from collections.abc import Callable
from html import escape

from experiments.report.report import MARKS, Block, Picture, Report, Section, Verdict
from experiments.report.table import Table

STYLE = """
:root { color-scheme: light dark; --ink: #1c2024; --soft: #5b636b; --page: #ffffff; --card: #f6f7f9; --line: #dfe3e8;
  --link: #0b5cad; --good: #007a59; --part: #8a5a00; --bad: #b3400a; }
@media (prefers-color-scheme: dark) { :root { --ink: #e6e8ea; --soft: #a3abb3; --page: #14171a; --card: #1d2125;
  --line: #343a41; --link: #7db8f0; --good: #3fcf9f; --part: #f0b04a; --bad: #ff8a5c; } }
* { box-sizing: border-box; }
html { scroll-behavior: smooth; scroll-padding-top: 1rem; }
body { margin: 0; font: 16px/1.55 system-ui, -apple-system, "Segoe UI", Roboto, "DejaVu Sans", sans-serif;
  color: var(--ink); background: var(--page); }
.frame { display: grid; grid-template-columns: 16rem minmax(0, 54rem); gap: 3rem; justify-content: center;
  padding: 2rem 1.5rem 5rem; }
nav { position: sticky; top: 2rem; align-self: start; max-height: calc(100vh - 4rem); overflow: auto;
  font-size: .875rem; }
nav ol { list-style: none; margin: 0; padding: 0; border-left: 2px solid var(--line); }
nav li { padding: .18rem 0 .18rem .9rem; } nav li.deep { padding-left: 1.9rem; }
nav strong { display: block; margin-bottom: .5rem; }
a { color: var(--link); text-decoration: none; } a:hover { text-decoration: underline; }
nav a { color: var(--soft); }
h1 { font-size: 2rem; line-height: 1.2; margin: 0 0 1rem; } h2 { font-size: 1.45rem; margin: 3.2rem 0 .8rem;
  padding-top: .8rem; border-top: 1px solid var(--line); } h3 { font-size: 1.12rem; margin: 2.2rem 0 .6rem; }
p { margin: .7rem 0; max-width: 46rem; }
code { font: .88em ui-monospace, "SF Mono", Menlo, "DejaVu Sans Mono", monospace; background: var(--card);
  padding: .08em .3em; border-radius: 4px; }
figure { margin: 1.4rem 0; } figure img { width: 100%; height: auto; display: block; background: #fff; padding: .5rem;
  border: 1px solid var(--line); border-radius: 8px; }
figcaption, caption { font-size: .875rem; color: var(--soft); text-align: left; }
figcaption { margin-top: .5rem; max-width: 46rem; } caption { padding-bottom: .5rem; }
.scroll { overflow-x: auto; margin: 1.4rem 0; }
table { border-collapse: collapse; font-size: .875rem; min-width: 60%; }
th { text-align: left; font-weight: 600; border-bottom: 2px solid var(--line); vertical-align: bottom; }
td, th { padding: .34rem .9rem .34rem 0; } td { border-bottom: 1px solid var(--line); vertical-align: top; }
.number { text-align: right; font-variant-numeric: tabular-nums; } td.number { white-space: nowrap; }
.verdict { margin: 1.2rem 0; padding: .8rem 1.1rem; background: var(--card); border-left: 4px solid var(--tone);
  border-radius: 0 8px 8px 0; max-width: 46rem; }
.verdict p { margin: .3rem 0; } .outcome { color: var(--tone); font-weight: 700; white-space: nowrap; }
.holds { --tone: var(--good); } .part { --tone: var(--part); } .fails { --tone: var(--bad); }
.none { --tone: var(--soft); }
@media (max-width: 60rem) { .frame { grid-template-columns: minmax(0, 54rem); gap: 1rem; } nav { position: static;
  max-height: none; } }
@media print { .frame { display: block; } nav { position: static; } figure, .verdict { break-inside: avoid; } }
"""
_CLASSES = {"holds": "holds", "holds in part": "part", "does not hold": "fails", "not judged": "none"}


def html(report: Report, svg: Callable[[Picture], bytes]) -> str:
    """The page.

    Args:
        report: what it says.
        svg: gives the bytes of a picture's SVG file.
    """
    contents = "".join(
        f'<li{" class=deep" if s.level > 2 else ""}><a href="#{escape(s.anchor)}">{escape(s.title)}</a></li>'
        for s in report.sections
    )
    body = [f"<h1>{escape(report.title)}</h1>", *(f"<p>{inline(text)}</p>" for text in report.lead), _glance(report)]
    for section in report.sections:
        tag = f"h{section.level}"
        body.append(f'<section id="{escape(section.anchor)}"><{tag}>{escape(section.title)}</{tag}>')
        body += [_block(block, svg) for block in section.blocks]
        body.append("</section>")
    return (
        '<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>{escape(report.title)}</title><style>{STYLE}</style></head>\n"
        f'<body><div class="frame"><nav aria-label="Contents"><strong>Contents</strong><ol>{contents}</ol></nav>\n'
        "<main>" + "\n".join(body) + "</main></div></body></html>\n"
    )


def inline(text: str) -> str:
    """Text as HTML: everything escaped, then **bold**, `code` and [words](#anchor)."""
    text = escape(text)
    text = re.sub(r"`([^`]+)`", r"<code>\1</code>", text)
    text = re.sub(r"\*\*([^*]+)\*\*", r"<strong>\1</strong>", text)
    return re.sub(r"\[([^]]+)\]\((#[\w-]+)\)", r'<a href="\2">\1</a>', text)


def _glance(report: Report) -> str:
    rows = "".join(
        f'<tr><td>{_link(section)}</td><td>{inline(v.claim)}</td><td class="{_CLASSES[v.outcome]}">{_mark(v)}</td></tr>'
        for section, v in report.verdicts()
    )
    head = "<thead><tr><th>Section</th><th>Claim</th><th>Verdict</th></tr></thead>"
    return f'<div class="scroll"><table><caption>At a glance</caption>{head}<tbody>{rows}</tbody></table></div>'


def _link(section: Section) -> str:
    return f'<a href="#{escape(section.anchor)}">{escape(section.title)}</a>'


def _mark(verdict: Verdict) -> str:
    return f'<span class="outcome">{MARKS[verdict.outcome]} {verdict.outcome}</span>'


def _block(block: Block, svg: Callable[[Picture], bytes]) -> str:
    match block:
        case str():
            return f"<p>{inline(block)}</p>"
        case Table():
            return f'<div class="scroll">{block.html()}</div>'
        case Picture():
            data = base64.b64encode(svg(block)).decode("ascii")
            image = f'<img alt="{escape(block.alt)}" src="data:image/svg+xml;base64,{data}">'
            return f"<figure>{image}<figcaption>{inline(block.caption)}</figcaption></figure>"
        case Verdict():
            return (
                f'<div class="verdict {_CLASSES[block.outcome]}"><p>{_mark(block)}</p>'
                f"<p><strong>Claim.</strong> {inline(block.claim)}</p>"
                f"<p><strong>Found.</strong> {inline(block.found)}</p></div>"
            )
