import os
import subprocess

import pytest

import psivox

ASSETS = os.environ["PSIVOX_ASSETS"]
PROGRAM = os.environ["PSIVOX_PROGRAM"]


@pytest.fixture(scope="session")
def blobs():
    return os.path.join(ASSETS, "blobs.vdb")


@pytest.fixture(scope="session")
def command():
    """Runs the program psivox; returns what it prints."""
    def run(*arguments):
        return subprocess.run([PROGRAM, *map(str, arguments)], check=True, capture_output=True,
                              text=True).stdout
    return run


@pytest.fixture
def refused():
    """Calls a function that must raise psivox.Error with a code; returns its one line."""
    def check(code, function, *arguments, **keywords):
        with pytest.raises(psivox.Error) as raised:
            function(*arguments, **keywords)
        text = str(raised.value)
        assert raised.value.exit_code == code, text
        assert text and "\n" not in text
        return text
    return check
