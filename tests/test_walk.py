"""The way of a study from `esfem run` to its verdict is a straight walk."""

import pytest
from shortcuts import PROCESSES, computed_by
from walk import Call, stays, walk_of_study

MOST_STAYS = 76  # properties of values that were handed over among them
MOST_CALLED = 56  # by calls that are written as such


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
    assert (rooms[0], rooms[-1]) == ("cli", "results")
    assert {"studies", "meshes", "runs", "judging"} <= set(rooms)


def test_the_walk_is_short(walk):
    assert len(stays(walk[0])) <= MOST_STAYS
    assert len(stays([call for call in walk[0] if not call.reads])) <= MOST_CALLED


def test_runs_are_selected_once_for_the_judge_and_once_for_the_reader(walk):
    assert walk[1]["esfem.results.selection"] == 2


def test_what_is_written_was_not_read_back(walk):
    assert not any("load_result" in call.function for call in walk[0])
