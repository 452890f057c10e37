"""Reports: sections, tables, figures, as HTML and Markdown."""
