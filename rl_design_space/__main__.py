"""`python -m rl_design_space` is `rl-design-space`."""

from rl_design_space.commands.cli import main

if __name__ == "__main__":
    main()
