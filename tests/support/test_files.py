"""Names of files: what is none is refused as such."""

from __future__ import annotations

import pytest

from ggo_factors.errors import InputError
from ggo_factors.support.files import read_text


@pytest.mark.parametrize("path", [3, None, "", "a\0b", ["base.csv"]])
def test_what_names_no_file(path):
    with pytest.raises(InputError, match="path: expected the name of a file, got "):
        read_text(path)


def test_text_that_is_none(tmp_path):
    path = tmp_path / "base.csv"
    path.write_bytes(b"# ggo\xff")
    with pytest.raises(InputError, match=r"base\.csv: is not a text file \(byte 5 is not UTF-8\)"):
        read_text(path)
    path.write_bytes(b"\xef\xbb\xbf# ggo")
    assert read_text(path) == "# ggo"
