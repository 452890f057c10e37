"""Laws of keys that are made for processes which are started one by one."""

from pathlib import Path

from network.access.keys import AUTHORITY, Keys
from runtime.hosts.issuing import issue


def test_they_are_made_once_and_all_anew_if_one_is_lost(tmp_path: Path) -> None:
    folder = tmp_path / "keys"
    assert issue(folder)
    first = (folder / AUTHORITY).read_text()
    assert all((file.stat().st_mode & 0o777) == 0o600 for file in folder.iterdir())
    assert not issue(folder)
    Keys.of(folder, "agent-64").key.unlink()
    assert issue(folder)
    assert (folder / AUTHORITY).read_text() != first
