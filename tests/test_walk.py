"""The way of a study from `esfem run` to its verdict is a straight walk."""

import re

import pytest
from shortcuts import PROCESSES, computed_by
from walk import ROOMS, ROOT, Call, stays, walk_of_study, way

MOST_STAYS = 30  # properties of values that were handed over among them
MOST_CALLED = 26  # by calls that are written as such


@pytest.fixture(scope="module")
def walk(tmp_path_factory):
    with computed_by(PROCESSES):
        return walk_of_study(tmp_path_factory.mktemp("walk"))


def test_a_stay_ends_where_another_room_is_entered():
    def call(leaves: str, room: str) -> Call:
        return Call("a", "b", "f", leaves, room, reads=False)

    ways = [("", "cli"), ("cli", "runs"), ("runs", "runs"), ("cli", "runs"), ("runs", "cli")]
    assert stays([call(*way) for way in ways]) == ["cli", "runs", "cli"]


def test_the_walk_goes_from_the_command_to_the_verdict(walk):
    rooms = stays(walk[0])
    assert (rooms[0], rooms[-1]) == ("cli", "judging")  # the last is the exit status
    assert {"studies", "meshes", "runs", "judging"} <= set(rooms)


def test_the_walk_is_short(walk):
    assert len(stays(walk[0])) <= MOST_STAYS
    assert len(stays([call for call in walk[0] if not call.reads])) <= MOST_CALLED


def test_the_way_is_told_in_ten_lines(walk):
    text = (ROOT / "docs" / "walk.md").read_text(encoding="utf-8")
    lines = re.findall(r"^\d+\. .*$", text, re.MULTILINE)
    named = re.findall(r"`((?:\w+\.)+\w+)`", "\n".join(lines))
    assert len(lines) == 10
    assert all(name.split(".")[0] in ROOMS for name in named)
    assert named == way(walk[0])


def test_runs_are_selected_once_for_the_judge_and_once_for_the_reader(walk):
    assert walk[1]["esfem.results.selection"] == 2


def test_what_is_written_was_not_read_back(walk):
    assert not any("load_result" in call.function for call in walk[0])
