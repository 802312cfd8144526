"""The names of the package: `symid` imports each from the module given here when it is used."""

from symid.axis import (
    Axis as Axis,
    axis_source as axis_source,
    chain as chain,
    load_axis as load_axis,
    write_axis as write_axis,
)
from symid.axis.drive_imperfections import *
from symid.axis.elements import (
    GROUND as GROUND,
    Between as Between,
    Body as Body,
    Damper as Damper,
    Drive as Drive,
    Geared as Geared,
    PendulumWeight as PendulumWeight,
    Spring as Spring,
    Weight as Weight,
)
from symid.axis.imperfections import *
from symid.axis.laws.along_stroke import *
from symid.axis.laws.constant import *
from symid.axis.laws.friction import *
from symid.axis.laws.law import *
from symid.axis.laws.spring import *
from symid.axis.sensors import *
from symid.codegen import compiled as compiled, load_generated as load_generated
from symid.codegen.generation import generate as generate
from symid.data import Log as Log, read_log as read_log
from symid.diagnosis import Diagnosis as Diagnosis, diagnose as diagnose
from symid.errors import SymidError as SymidError
from symid.fleet import Batch as Batch, BatchSettings as BatchSettings, identify_batch as identify_batch
from symid.identification import (
    Identification as Identification,
    Preparation as Preparation,
    predict as predict,
    read_axis_log as read_axis_log,
)
from symid.simulation import simulate as simulate
from symid.symbolic import DerivedModel as DerivedModel, derive as derive
from symid.tuning import Tuning as Tuning, tune as tune
from symid.verbs.identify_any import identify as identify
from symid.verbs.methods import (
    InstrumentalVariables as InstrumentalVariables,
    OrdinaryLeastSquares as OrdinaryLeastSquares,
    OutputError as OutputError,
    WeightedLeastSquares as WeightedLeastSquares,
)

__version__: str
