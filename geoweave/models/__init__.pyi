from . import catalogue as catalogue, datasets as datasets, shapes as shapes
from .catalogue import MODELS as MODELS, Model as Model, about as about, load as load
