"""Logs of machines: reading, checking, resampling and writing them.

`text_files` and `formats` make tables of files, `quality` checks clock and channels, `reading` makes a `Log` of a
table.
"""

from symid.lazy_face import lazy_face

__getattr__, __dir__ = lazy_face(__name__)
