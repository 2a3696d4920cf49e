"""Normal contact laws, one file a law. A new law is a file here and a line below.

Several share a form of the elastic force (``forms``) and the factors of hysteresis damping (``damping``).
"""

from .anagnostopoulos import Anagnostopoulos
from .dubowsky_freudenstein import DubowskyFreudenstein
from .esdu_78035 import Esdu78035
from .flores import Flores
from .goldsmith import Goldsmith
from .gonthier import Gonthier
from .herbert_mcwhannell import HerbertMcWhannell
from .hertz import Hertz
from .hu_guo import HuGuo
from .hunt_crossley import HuntCrossley
from .hydrodynamic import Hydrodynamic
from .impact import Impact
from .johnson import Johnson
from .kelvin_voigt import KelvinVoigt
from .lankarani_nikravesh import LankaraniNikravesh
from .lee_wang import LeeWang
from .liu import Liu
from .pereira import Pereira
from .radzimovsky import Radzimovsky
from .tabulated import Tabulated
from .zhiying_qishao import ZhiyingQishao

__all__ = [
    "Anagnostopoulos",
    "DubowskyFreudenstein",
    "Esdu78035",
    "Flores",
    "Goldsmith",
    "Gonthier",
    "HerbertMcWhannell",
    "Hertz",
    "HuGuo",
    "HuntCrossley",
    "Hydrodynamic",
    "Impact",
    "Johnson",
    "KelvinVoigt",
    "LankaraniNikravesh",
    "LeeWang",
    "Liu",
    "Pereira",
    "Radzimovsky",
    "Tabulated",
    "ZhiyingQishao",
]
