"""Commands that start a live run or talk to one."""
