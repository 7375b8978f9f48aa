# names of jo.sections; they are loaded from here when they are first used
from .points import StressPoint as StressPoint
from .section import GeneralSection as GeneralSection, SectionPoint as SectionPoint
