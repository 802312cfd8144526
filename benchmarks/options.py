"""Options of the benchmarks; the text of a benchmark is its help."""

import argparse


def parser_of(text: str | None, **defaults: float | str) -> argparse.ArgumentParser:
    """Parser of an option for each default: `logs=60` becomes `--logs N`, `quick=False` a switch `--quick`."""
    parser = argparse.ArgumentParser(description=text, formatter_class=argparse.RawDescriptionHelpFormatter)
    for name, default in defaults.items():
        if default is False:
            parser.add_argument(f"--{name}", action="store_true")
        else:
            parser.add_argument(f"--{name}", type=type(default), default=default, help=f"[{default}]")
    return parser
