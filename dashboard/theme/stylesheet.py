"""The page's style sheet: both looks' colours as variables, and what viser leaves to be wished for."""

from dashboard.theme.palette import DARK, LIGHT, Palette

_LOST = 'div[style*="opacity: 0.5;"][style*="pointer-events: none"]'
"""What viser dims while it has no server (DisconnectedGate of its client)."""
_RULES = f"""
/* lines fade into a background that the renderer's tone curve can reach */
:root[data-mantine-color-scheme="light"] canvas[data-engine]{{background:#{LIGHT.background}}}
[data-tap]{{cursor:pointer;user-select:none}}
[data-tap]:hover{{filter:brightness(1.15)}}
/* rows end before the scroll bar */
.mantine-ScrollArea-content{{box-sizing:border-box;padding-right:7px}}
/* notices: out of the robots' way, and never over a question */
.mantine-Notifications-root{{--notifications-z-index:90!important;top:auto!important;bottom:1em}}
.mantine-Notification-root{{font-size:12px}}
.mantine-Notification-title,.mantine-Notification-description{{font-size:12px;line-height:1.4}}
/* a page that lost its server says so */
:root:has({_LOST}) body::after{{content:"The dashboard is gone. This page waits for it, and comes back by itself.";
position:fixed;top:58px;left:50%;transform:translateX(-50%);z-index:500;padding:8px 16px;border-radius:6px;
background:#{DARK.warn};color:#10151a;font:600 13px system-ui,sans-serif;white-space:nowrap}}
"""


def sheet() -> str:
    """Colours are var(--ok), var(--warn), var(--bad), var(--muted), var(--r1) and so on."""
    looks = "".join(
        f':root[data-mantine-color-scheme="{"dark" if palette.dark else "light"}"]{{{_variables(palette)}}}'
        for palette in (DARK, LIGHT)
    )
    return f"<style>{looks}{_RULES}</style>"


def _variables(palette: Palette) -> str:
    return "".join(f"--{name}:#{colour};" for name, colour in palette.named().items())
