"""The check for the system's graphics libraries."""

from sim import system_libraries


def test_nothing_is_missing_where_the_film_runs(capsys):
    assert system_libraries.main() == 0
    assert capsys.readouterr().out == ""


def test_without_the_right_to_install_it_prints_the_command_and_exits_with_two(monkeypatch, capsys):
    monkeypatch.setattr(system_libraries, "LIBRARIES", ("libNoSuchThing.so.7",))
    monkeypatch.setattr(system_libraries.os, "geteuid", lambda: 1000)
    assert system_libraries.main() == 2
    error = capsys.readouterr().err
    assert "libNoSuchThing.so.7" in error
    assert "apt-get install" in error
