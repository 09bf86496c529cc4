from . import doctor as doctor, figures as figures
from .doctor import examine as examine
