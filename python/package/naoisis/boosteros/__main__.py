"""The command ``python -m naoisis.boosteros``."""

from naoisis.boosteros.runner import main

main()
