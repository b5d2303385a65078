"""The base class of executors on clusters: checks of their config, and learning in chunks."""

from __future__ import annotations

import socket
from abc import ABC, abstractmethod
from collections.abc import Generator, Iterator
from importlib import import_module
from typing import Any, ClassVar
from urllib.parse import urlsplit

from rl_design_space.errors import ConfigError
from rl_design_space.plan.plan import PlannedPoint
from rl_design_space.run.clusters.chunks import Cluster, learn_in_chunks
from rl_design_space.run.executor import PointResult

#: Seconds to wait for an answer of the scheduler of a cluster.
CONNECT_TIMEOUT = 10


class ClusterExecutor(ABC):
    """Learns on the workers of a cluster; results return to this process, so no shared disk is needed.

    Args:
        address: address of the cluster; if None, a cluster is started on this machine and stopped after learning.
        chunk: number of points per task; if None, few enough that all workers stay busy to the end.
        threads: number of workers of a cluster that is started here.

    Raises:
        ConfigError: a value is not allowed, the extra is not installed, or nothing answers at the address.
    """

    name: ClassVar[str]
    #: The extra of this package that has to be installed, and a module that it installs.
    extra: ClassVar[str]
    module: ClassVar[str]
    #: Examples of addresses for messages, and symbolic addresses, which the library resolves.
    addresses: ClassVar[str]
    symbolic: ClassVar[tuple[str, ...]] = ()

    def __init__(self, address: str | None, chunk: int | None, threads: int) -> None:
        if chunk is not None and (type(chunk) is not int or chunk < 1):
            raise ConfigError.at("hydra.launcher.chunk", chunk, "should be null or a whole number of at least 1")
        self._address, self._chunk, self._threads = address, chunk, threads
        try:
            self._library: Any = import_module(self.module)
        except ImportError as error:
            raise ConfigError(
                f"hydra/launcher=design_{self.extra}: needs {self.name}; pip install 'rl-design-space[{self.extra}]'"
            ) from error
        if address is not None and address not in self.symbolic:
            _check_connection(address, self.addresses)

    @abstractmethod
    def start(self) -> Cluster:
        """Connect to the cluster, or start one.

        Raises:
            ConfigError: no such cluster answers at the address.
        """

    def describe(self) -> str:
        if self._address is not None:
            return f"{self.name} workers at {self._address}"
        return f"{self._threads} {self.name} worker{'s' if self._threads > 1 else ''}"

    def learn(self, points: Iterator[PlannedPoint | None]) -> Generator[PointResult, None, None]:
        yield from learn_in_chunks(self.start(), points, self._chunk)


def unreachable(address: str, error: Exception) -> ConfigError:
    """Return an error for an address where no cluster answers."""
    reason = " ".join(str(error).split()) or type(error).__name__
    return ConfigError.at("hydra.launcher.address", address, f"no cluster can be reached there: {reason}")


def unusable(address: str | None, error: BaseException) -> ConfigError:
    """Return an error for a cluster whose workers cannot learn, or that is gone."""
    reason = f"{type(error).__name__}: {error}".split("\n")[0]
    return ConfigError.at("hydra.launcher.address", address, f"the cluster cannot be used: {reason}")


def _check_connection(address: object, form: str) -> None:
    """Raise an error at once if nothing answers at an address."""
    text = str(address)
    try:
        parts = urlsplit(text if "://" in text else f"//{text}")
        host, port = parts.hostname, parts.port
    except ValueError:
        host = port = None
    if not host or not port:
        raise ConfigError.at("hydra.launcher.address", address, f"should be null or like {form}")
    try:
        socket.create_connection((host, port), timeout=CONNECT_TIMEOUT).close()
    except OSError as error:
        raise unreachable(text, error) from error
