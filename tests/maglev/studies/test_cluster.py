"""The cluster of this machine: nobody else can reach it, and who can is not let in."""

import os
from collections.abc import Iterator
from urllib.error import HTTPError
from urllib.request import urlopen

import pytest
from distributed import Client
from distributed.security import Security
from psutil import CONN_LISTEN, Process
from tiny_study import address_of, trusted

from maglev.errors import ScenarioError
from maglev.studies.flying import cluster


@pytest.fixture(scope="module")
def client(slow: None) -> Iterator[Client]:
    with cluster.connected(None, 2) as client:
        yield client


def addresses(client: Client) -> list[str]:
    """Of the scheduler, the workers and their nannies."""
    workers = client.scheduler_info()["workers"]
    return [address_of(client), *workers, *(each["nanny"] for each in workers.values())]


def processes(client: Client) -> list[Process]:
    return [Process(), *map(Process, client.run(os.getpid).values())]


def test_it_listens_on_this_machine_alone(client: Client) -> None:
    found = [connection.laddr for process in processes(client) for connection in process.net_connections("inet")
             if connection.status == CONN_LISTEN]
    assert len(found) >= 5   # the scheduler, two workers and their nannies
    assert {address.ip for address in found} == {"127.0.0.1"}


def test_it_shows_nothing(client: Client) -> None:
    """What Dask serves of every cluster, without a login: no page of these is there."""
    pages = [f"http://127.0.0.1:{client.scheduler_info()['services']['dashboard']}",
             *(f"http://127.0.0.1:{each['services']['dashboard']}"
               for each in client.scheduler_info()["workers"].values())]
    for page in pages:
        for path in ("/", "/status", "/metrics", "/json/identity.json", "/health"):
            with pytest.raises(HTTPError, match="404"):
                urlopen(page + path, timeout=10.0)


def test_a_stranger_is_refused(client: Client) -> None:
    """With no certificate, and with one of its own; by the scheduler, the workers and their nannies."""
    for address in addresses(client):
        assert address.startswith("tls://127.0.0.1:")
        with pytest.raises(OSError):
            Client(address.replace("tls://", "tcp://"), timeout=5.0, security=Security())
        with pytest.raises(OSError):
            Client(address, timeout=5.0, security=Security.temporary())
    assert client.submit(os.getpid, pure=False).result(timeout=30.0)   # it lives on


def test_who_has_its_certificate_is_let_in(client: Client) -> None:
    with trusted(client.security), cluster.connected(address_of(client), 1) as other:
        assert set(other.run(os.getpid)) == set(client.run(os.getpid))


def test_without_a_certificate_one_line_says_so(client: Client) -> None:
    with pytest.raises(ScenarioError, match=r"--scheduler tls://.*: cannot be reached .*TLS") as refusal, \
            cluster.connected(address_of(client), 1):
        pass
    assert "\n" not in str(refusal.value)
