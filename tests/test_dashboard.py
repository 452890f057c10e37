"""Laws of what the dashboard shows, without a browser."""

import logging
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from queue import SimpleQueue
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dashboard import colours, faults, geometry, server, tables, words
from dashboard.access import Guard
from dashboard.desk import Desk
from dashboard.feed import Feed
from dashboard.history import History
from dashboard.layers import held_plans, outline_colours
from dashboard.links import LOST_SECONDS, LinkView, links
from dashboard.page import Page
from dashboard.palette import DARK, LIGHT
from dashboard.plans import KEPT_BYTES, PLAN_BYTES, PlanLog
from dashboard.series import POINTS
from dashboard.server import serve
