"""Prints what does not belong on its standard output, then fails."""

TITLE = "broken"
PERIODS = 500


def version():
    print("noise")
    return "broken 1"


def prepare(job):
    raise ValueError(f"cannot learn on {job.cells} cells")
