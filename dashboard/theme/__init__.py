"""How the page looks: colours, style sheet, and how numbers are written."""
