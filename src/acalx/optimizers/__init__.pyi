from .base import Optimizer as Optimizer
from .convex import Convex as Convex
from .de import DifferentialEvolution as DifferentialEvolution
from .exchange import Exchange as Exchange
from .gradient import Gradient as Gradient
from .nsga2 import NSGA2 as NSGA2
from .scalarized import Scalarized as Scalarized
from .traversal import Traversal as Traversal
