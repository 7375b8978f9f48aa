"""One declaration: constructor, checks, help, register and file entry follow from the fields."""

from __future__ import annotations

import inspect
import pickle

import numpy as np
import pytest

from jousto.base.declare import SECTIONS, Declared, kinds
from jousto.base.errors import InputError, Problems
from jousto.base.fields import AnyField, Choice, Flag, Name, Text, field
from jousto.base.numbers import Number, Numbers, OptionalNumber
from jousto.schema.entries.declared import entry_of


class Pet(Declared, section="pets of the test"):
    """An animal."""

    kind = "pet"
    name: Name = field("Unique among pets")
    tame: Flag = field("Whether it is tame", default=True, kw_only=True)


class Cat(Pet, tag="cat"):
    """A pet that purrs."""

    mass: Number = field("How heavy it is", unit="kg", above=0, remedy="weigh it again")
    tail: OptionalNumber = field("Length of its tail", unit="m", least=0, default=None)
    colour: Choice = field("Its fur", words=("black", "grey"), default="black")

    def consistent(self, problems: Problems, where: str) -> None:
        """Note a tail that is too heavy."""
        if self.tail is not None and self.tail > self.mass:
            problems.add(where, "its tail is longer than it is heavy")


class Quiet(Declared):
    """A base that adds a field after those of `Pet`, where it comes second in the order."""

    voice: Text = field("What it says", default="nothing")


class Fish(Quiet, Pet, tag="fish"):
    """A pet without a voice."""

    scales: Numbers = field("Sizes of its scales", default=(1.0,))
    friend: AnyField = field("Any other", default=None, file=False)


def test_the_constructor_takes_the_fields_in_their_order():
    parameters = inspect.signature(Cat).parameters
    assert list(parameters) == ["name", "mass", "tail", "colour", "tame"]
    assert parameters["tame"].kind is inspect.Parameter.KEYWORD_ONLY
    cat = Cat("tom", np.int64(4), colour="grey")
    assert (cat.name, cat.mass, cat.tail, cat.colour, cat.tame) == ("tom", 4.0, None, "grey", True)
    assert type(cat.mass) is float
    with pytest.raises(AttributeError, match="mass"):
        cat.mass = 3.0  # type: ignore[misc]


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"mass": -1}, "pet 'tom': mass is -1 kg, must be positive; weigh it again"),
        ({"mass": "3 kg"}, "pet 'tom': mass is '3 kg', must be a number"),
        ({"mass": float("nan")}, "pet 'tom': mass is nan, must be finite"),
        ({"tail": -0.5}, "pet 'tom': tail is -0.5 m, must not be negative"),
        ({"colour": "red"}, "pet 'tom': colour is 'red', must be 'black' or 'grey'"),
        ({"tame": 1}, "pet 'tom': tame is 1, must be True or False"),
        ({"tail": 9.0}, "pet 'tom': its tail is longer than it is heavy"),
        ({"name": " "}, "pet ' ': name must not be empty or start or end with a blank"),
    ],
)
def test_each_field_says_what_is_wrong_with_it(given, message):
    with pytest.raises(InputError) as error:
        Cat(**{"name": "tom", "mass": 4.0, **given})
    assert str(error.value) == message


def test_all_problems_are_reported_together():
    with pytest.raises(InputError) as error:
        Cat("tom", -1.0, colour="red", tame="yes")
    assert [p.message.split()[0] for p in error.value.problems] == ["tame", "mass", "colour"]


def test_none_is_a_value_of_what_is_optional():
    class Bird(Pet, tag="bird"):
        """A pet that flies."""

        span: OptionalNumber = field("Of its wings", unit="m", above=0, default=1.0)
        mass: Number = field("How heavy it is", unit="kg", default=1.0)

    try:
        assert Bird("jay").span == 1.0
        assert Bird("jay", span=None).span is None
        with pytest.raises(InputError, match="pet 'jay': mass is None, must be a number"):
            Bird("jay", mass=None)
    finally:
        del SECTIONS["pets of the test"]["bird"]


def test_fields_of_several_bases_come_together():
    fish = Fish("wanda", scales=[1, 2.5])
    assert fish.scales == (1.0, 2.5)
    assert fish.voice == "nothing"
    assert set(Fish.fields) == {"name", "tame", "voice", "scales", "friend"}
    with pytest.raises(InputError, match=r"scales\[1\] is 0, must not be zero"):
        Fish("wanda", scales=(1, 0))


def test_kinds_are_registered_by_their_word():
    assert SECTIONS["pets of the test"] == {"cat": Cat, "fish": Fish}
    joints = kinds("joints", "jousto.mechanism.joints")
    assert joints["revolute"].__name__ == "Revolute"
    assert {cls.tag for cls in joints.values()} == set(joints)


def test_a_field_shows_what_it_is():
    assert repr(Cat.fields["mass"]) == "<Number 'mass': How heavy it is, kg>"


def test_help_lists_every_field_with_its_unit():
    text = inspect.getdoc(Cat)
    assert text.startswith("A pet that purrs.\n\nParameters\n----------\nname : str\n")
    assert "mass : float\n    How heavy it is, kg." in text
    assert 'colour : {"black", "grey"}, optional\n    Its fur.' in text


def test_the_entry_of_a_file_has_the_same_keys():
    entry = entry_of(Fish)
    assert set(entry.model_fields) == {"type", "name", "tame", "voice", "scales"}
    schema = entry_of(Cat).model_json_schema()
    assert schema["required"] == ["type", "name", "mass"]
    assert "How heavy it is" in schema["properties"]["mass"]["description"]
    assert schema["properties"]["colour"]["anyOf"][0]["enum"] == ["black", "grey"]


def test_objects_travel_to_other_processes():
    cat = pickle.loads(pickle.dumps(Cat("tom", 4.0)))
    assert (cat.name, cat.mass) == ("tom", 4.0)


def test_a_class_may_be_declared_anywhere():
    words = ("a", "b")

    class Local(Pet, tag="local"):
        """A class inside a function, with names of the function."""

        letter: Choice = field("One of them", words=words)

    try:
        assert Local("x", "a").letter == "a"
    finally:
        del SECTIONS["pets of the test"]["local"]


class Foam(Declared, section="matter of the test", tag="foam"):
    """Matter of units that no other class has."""

    name: Name = field("Unique")

    hardening: Number = field("Its cubic stiffness", unit="N/m3")
    growth: Number = field("By temperature", unit="1/K", default=0.0)


def test_a_field_may_have_any_unit_of_the_vocabulary():
    entry = entry_of(Foam)
    one = entry.model_validate({"type": "foam", "name": "f", "hardening": "2 N/mm3"})
    assert one.hardening == 2e9
    one = {"type": "foam", "name": "f", "hardening": 1, "growth": "12e-6 1/K"}
    assert entry.model_validate(one).growth == 12e-6
    with pytest.raises(ValueError, match=r"expects a number in N/m3, got 3 N/m \(a stiffness"):
        entry.model_validate({"type": "foam", "name": "f", "hardening": "3 N/m"})

    said = entry.model_json_schema()["properties"]
    assert said["hardening"]["description"] == "Its cubic stiffness, N/m3"


def test_a_unit_of_other_words_is_refused_where_the_class_is_written():
    with pytest.raises(InputError) as error:

        class Odd(Foam, tag="odd"):
            load: Number = field("What it carries", unit="Nn/m3")
            free: Number = field("What files cannot give", unit="N or N m", file=False)

    assert str(error.value) == (
        "Odd.load: its unit is 'Nn/m3': unknown unit 'Nn'; did you mean 'N'?"
    )
    assert "odd" not in SECTIONS["matter of the test"]


def test_a_call_with_wrong_arguments_says_which_there_are():
    with pytest.raises(
        InputError, match="^pet 'Tom': there is no argument 'tial'; did you mean 't"
    ):
        Cat("Tom", 4.0, tial=0.3)
    with pytest.raises(
        TypeError, match=r"^pet 'Tom': missing .* 'mass'; it is called Cat\(name, mass"
    ):
        Cat("Tom")
    with pytest.raises(InputError, match="^pet 'Tom': 5 arguments without a name are too many; it"):
        Cat("Tom", 4.0, 0.3, "grey", True)
    assert str(inspect.signature(Cat)).startswith("(name: 'str', mass: 'float', tail")


def test_an_error_within_a_constructor_stays_what_it_is():
    class Broken(Pet):
        def consistent(self, problems: Problems, where: str) -> None:
            raise TypeError("inside")

    with pytest.raises(TypeError, match="^inside$"):
        Broken("Tom")
