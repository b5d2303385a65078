"""Hash tables from observation codes to rows."""

from __future__ import annotations

from rl_design_space.learning.compiled import compiled, inlined


def slot_count(codes: int) -> int:
    """Return the number of slots for this many codes: at least half are empty, so that a look-up takes few probes."""
    return 1 << (2 * codes - 1).bit_length()


@inlined
def bits_of(known_rows):
    """Return the number of bits of a slot; the number of slots is a power of two."""
    mask = len(known_rows) - 1
    bits = 0
    while mask >> bits:
        bits += 1
    return bits


@inlined
def slot_of(code, known_codes, known_rows, bits):
    """Return the slot of a code, or the one where it belongs; its row is negative if it is not known.

    Args:
        code: the observation code.
        known_codes: code in each slot.
        known_rows: row of that code; negative in a slot without one.
        bits: see `bits_of`.
    """
    mask = len(known_rows) - 1
    # Consecutive codes get consecutive slots.
    slot = (code + (code >> bits) * 0x9E3779B1) & mask
    while known_rows[slot] >= 0 and known_codes[slot] != code:
        slot = (slot + 1) & mask
    return slot


@compiled
def numbered(codes, known_codes, known_rows, row_of):
    """Number the rows of codes in the order in which these first occur; return the number of rows.

    Args:
        codes: (states,) observation codes.
        known_codes: of a hash table, output.
        known_rows: of a hash table, output.
        row_of: (states,) output: the row of each state.
    """
    bits = bits_of(known_rows)
    known_rows[:] = -1
    n_rows = 0
    for at in range(len(codes)):
        slot = slot_of(codes[at], known_codes, known_rows, bits)
        if known_rows[slot] < 0:
            known_rows[slot] = n_rows
            known_codes[slot] = codes[at]
            n_rows += 1
        row_of[at] = known_rows[slot]
    return n_rows
