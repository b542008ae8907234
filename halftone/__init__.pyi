from halftone.dithering.classes import ClassMatrix as ClassMatrix
from halftone.dithering.curve import Riemersma as Riemersma
from halftone.dithering.diffusion import ErrorDiffusion as ErrorDiffusion
from halftone.dithering.diffusion import FloydSteinberg as FloydSteinberg
from halftone.dithering.dots import DotDiffusion as DotDiffusion
from halftone.dithering.filters import ErrorFilter as ErrorFilter
from halftone.dithering.noise import RandomDither as RandomDither
from halftone.dithering.ordered import Ordered as Ordered
from halftone.dithering.registry import method as method
from halftone.dithering.registry import methods as methods
from halftone.dithering.threshold import Nearest as Nearest
from halftone.dithering.threshold import Threshold as Threshold
from halftone.dithering.toned import ToneDiffusion as ToneDiffusion
from halftone.errors import HalftoneError as HalftoneError
from halftone.errors import InputError as InputError
from halftone.errors import InputFileError as InputFileError
from halftone.errors import OutputError as OutputError
from halftone.errors import UsageError as UsageError
from halftone.frame import Frame as Frame
from halftone.packing import Packing as Packing
from halftone.pipeline import convert as convert
from halftone.pipeline import dither as dither
from halftone.pipeline import read as read
from halftone.screens.order import Screen as Screen
from halftone.tone.levels import Levels as Levels

__version__: str
