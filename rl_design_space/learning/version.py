"""The version of the learning algorithm."""

#: Part of every fingerprint. Raise it whenever a change to the kernel alters results; a test holds their digest.
KERNEL_VERSION = 1
