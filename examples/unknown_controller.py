"""A drive with an unknown controller: least squares does not need it, and its gains can be estimated from a log."""

from symid import identify, load_axis, read_axis_log
from symid.axis import shipped_folder

EMPS = shipped_folder("data") / "emps" / "DATA_EMPS.mat"


def main() -> None:
    """Identify EMPS by least squares, and by instruments from a loop whose gains were read from the log."""
    axis = load_axis("emps")
    log = read_axis_log(axis, EMPS, columns={"q": "qm", "reference": "qg"})
    by_squares = identify(axis, log)
    by_instruments = identify(axis, log, method="iv")
    for method, found in (("least squares", by_squares), ("instruments", by_instruments)):
        values = ", ".join(f"{name} {value:.4g}" for name, value in found.physical_parameters.items())
        print(f"{method}: {values}")
    print(*(note for note in by_instruments.notes if "Kpp" in note), sep="\n")


if __name__ == "__main__":
    main()
