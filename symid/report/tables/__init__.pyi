"""Names of the tables and records that commands print or write."""

from symid.report.tables.console import TextTable as TextTable, report_console as report_console
from symid.report.tables.derivation import (
    derivation_record as derivation_record,
    print_derivation as print_derivation,
)
from symid.report.tables.diagnosis import (
    diagnosis_record as diagnosis_record,
    print_diagnosis as print_diagnosis,
)
from symid.report.tables.fleet import (
    fleet_record as fleet_record,
    print_batch as print_batch,
    print_fleet as print_fleet,
)
from symid.report.tables.identification import (
    identification_record as identification_record,
    print_identification as print_identification,
    print_shared as print_shared,
    shared_record as shared_record,
)
from symid.report.tables.output_error import output_error_record as output_error_record
from symid.report.tables.result_comparison import (
    comparison_record as comparison_record,
    print_comparison as print_comparison,
    values_of_record as values_of_record,
)
from symid.report.tables.tuning import (
    print_total_tuning as print_total_tuning,
    print_tuning as print_tuning,
    total_record as total_record,
    tuning_record as tuning_record,
)
