"""Results as self-contained HTML files."""

from symid.lazy_face import lazy_face

__getattr__, __dir__ = lazy_face(__name__)
