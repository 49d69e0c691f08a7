"""The small team of `dribblers.py` with a robot's own ears: of the game it knows what the GameController tells it over UDP.

    naoisis run match3v3 --blue "exec:python3 clients/python/controlled_dribblers.py 5" --team-numbers 5,12 \
        --game-controller v18 --game-controller-address 127.255.255.255
"""

import os
import sys

import dribblers
from game_controller import GameController
from naoisis_agent import play


def main(team, port_offset=0):
    player = int("".join(letter for letter in os.environ["NAOISIS_ROBOT"] if letter.isdigit()))
    controller = GameController(team, player, port_offset)

    def decide(perception):
        told = controller.game()
        if told is None:
            return {}
        ball = perception["percepts"]["ball"]
        fallen = perception["body"] == "fallen"
        controller.report(fallen=fallen, ball=ball and ball["position_m"])
        own_end = "negative_x" if told["is_left"] else "positive_x"
        game = {"state": told["state"], "penalised": told["penalty"] != 0, "own_end": own_end}
        return dribblers.decide({**perception, "game": game})

    play(decide, name="controlled dribblers")


if __name__ == "__main__":
    main(*(int(word) for word in sys.argv[1:]))
