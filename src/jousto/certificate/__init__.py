"""CERTIFY: assessment of a reduced part (`certify`, `advise`) and of a mechanism (`doctor`)."""

from jousto.base.lazy_exports import open_room

open_room(__name__)
