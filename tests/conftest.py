"""What all tests share: what they import is on the path, and properties draw the same examples every time."""

import sys
from pathlib import Path

from hypothesis import settings

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE), str(HERE.parent)]  # the catalogue of axes, and the benchmarks, are not installed

settings.register_profile(
    "same examples every time", derandomize=True, deadline=None, database=None, max_examples=50
)
settings.load_profile("same examples every time")
