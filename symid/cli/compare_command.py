"""`symid compare`: two results side by side."""

import shlex
import sys

import click

from symid.cli.options import give_result, json_option, page_of, report_option
from symid.cli.outputs import SafeCommand
from symid.files import read_json
from symid.report.tables import comparison_record, print_comparison, values_of_record


@click.command("compare", cls=SafeCommand, epilog="Example: symid compare monday.json friday.json")
@click.argument("first", metavar="A.json")
@click.argument("second", metavar="B.json")
@report_option
@json_option
def command(first: str, second: str, report: str | None, json_file: str | None) -> None:
    """Compare the parameters of A.json and B.json: of symid identify or diagnose, or names with values.

    A difference of more than three deviations is named. Where both results have covariances, all parameters are
    compared together too, which their correlations can decide when no single parameter does. The errors that the
    two models leave, their effects and their settings stand beside each other.
    """
    record = comparison_record(*(values_of_record(read_json(file), file) for file in (first, second)))
    if page_of(report):
        # matplotlib takes a second to load
        from symid.report.pages import write_comparison_html

        write_comparison_html(record, str(report), shlex.join(["symid", *sys.argv[1:]]))
    give_result(record, json_file, print_comparison)
