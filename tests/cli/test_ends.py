"""How the command ends where it is not a refusal: help, Ctrl-C, a reader that has gone, a fault of its own."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

import ggo_factors as ggo
from ggo_factors.cli import console, main


def test_the_bare_command_tells_what_there_is(capsys):
    assert main([]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.startswith("Usage: ggo ")
    assert "step-over" in captured.err


def test_ctrl_c_is_one_line(capsys, monkeypatch):
    def stopped(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(ggo, "adjust_stride", stopped)
    assert main(["stride", "paper"]) == 1
    captured = capsys.readouterr()
    assert (captured.out, captured.err.strip()) == ("", "ggo: stopped")


def test_a_fault_of_the_program_is_one_line_or_where_it_is(capsys, monkeypatch):
    def faulty(*_, **__):
        raise ZeroDivisionError("by\nnought")

    monkeypatch.setattr(ggo, "adjust_stride", faulty)
    command = ["stride", "paper"]
    monkeypatch.delenv("GGO_DEBUG", raising=False)
    assert main(command) == 1
    assert capsys.readouterr().err == "ggo: ZeroDivisionError: by nought (GGO_DEBUG=1 shows where)\n"
    monkeypatch.setenv("GGO_DEBUG", "1")
    with pytest.raises(ZeroDivisionError):
        main(command)


def test_a_reader_that_has_gone_is_no_traceback():
    read, write = os.pipe()
    os.close(read)
    command = [sys.executable, "-m", "ggo_factors.cli", "stride", "paper"]
    try:
        done = subprocess.run(command, check=False, stdout=write, stderr=subprocess.PIPE, text=True, timeout=60)
    finally:
        os.close(write)
    assert (done.returncode, done.stderr) == (1, "")


def test_progress_is_shown_to_a_terminal_only(capsys, monkeypatch):
    with console.progress_bar("reading") as progress:
        assert progress is None
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    with console.progress_bar("reading") as progress:
        progress(0.25)
    captured = capsys.readouterr()
    assert captured.out == ""
    assert "reading" in captured.err
    assert "25%" in captured.err
