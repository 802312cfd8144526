"""symid: declare a machine axis, derive its regressors, identify it, and learn why simulation and machine differ.

Declaring an axis needs neither sympy nor scipy: each name is imported when it is used.
"""

from symid.lazy_face import lazy_face

__version__ = "0.1.0"
__getattr__, __dir__ = lazy_face(__name__)
