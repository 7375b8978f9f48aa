# names of jo.certificate; they are loaded from here when they are first used
from .advice import Advice as Advice, advise as advise
from .certificate import Certificate as Certificate, Check as Check
from .certify import certify as certify
from .doctor import Diagnosis as Diagnosis
