"""The command ``python -m naoisis.boosteros``."""

from naoisis.boosteros.runner import main

if __name__ == "__main__":
    main()
