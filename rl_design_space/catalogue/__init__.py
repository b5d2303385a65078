"""What there is to choose from, read from the config files and from the classes that they name.

Nothing is written here for people that is not said there: a description is the leading comment of a file or the
docstring of its class, a range is the annotation of a field, a default is the file's value.
"""
