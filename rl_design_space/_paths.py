"""Where the shipped configuration lies."""

from pathlib import Path

_PACKAGE = Path(__file__).parent

#: `conf` inside the package when installed from a wheel, beside it in a checkout.
CONF = next((path for path in (_PACKAGE / "conf", _PACKAGE.parent / "conf") if path.is_dir()), _PACKAGE / "conf")
