"""Names of the pages that commands print or write."""

from symid.report.pages.comparison_page import write_comparison_html as write_comparison_html
from symid.report.pages.diagnosis_page import write_diagnosis_html as write_diagnosis_html
from symid.report.pages.fleet_page import write_fleet_html as write_fleet_html
from symid.report.pages.identification_page import write_identification_html as write_identification_html
from symid.report.pages.page import html_path as html_path
