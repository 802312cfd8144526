"""Results as figures of matplotlib."""

from symid.lazy_face import lazy_face

__getattr__, __dir__ = lazy_face(__name__)
