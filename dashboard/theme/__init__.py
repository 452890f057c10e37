"""How the page looks: colours, style sheet, templates, and how numbers are written."""
