from .base import Composed as Composed
from .base import Part as Part
from .base import Scheme as Scheme
from .joint import Joint as Joint
from .parallel import Parallel as Parallel
from .serial import Serial as Serial
