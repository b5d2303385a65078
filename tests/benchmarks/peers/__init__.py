"""Peers that do what a peer should not do."""
