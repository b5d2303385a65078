"""Analysis: frames in, frames out, no input or output and no learning."""
