"""Reports for any study and any selection of runs."""
