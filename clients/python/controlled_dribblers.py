"""The small team of `dribblers.py` with a robot's own ears: of the game it knows what the GameController tells it over UDP.

    naoisis run match3v3 --blue "exec:python3 clients/python/controlled_dribblers.py 5" --team-numbers 5,12 \
        --game-controller v18 --game-controller-address 127.255.255.255
"""

import os
import sys

from dribblers import Dribbler
from game_controller import GameController
from naoisis_agent import Agent


def main(team, port_offset=0):
    player = int("".join(letter for letter in os.environ["NAOISIS_ROBOT"] if letter.isdigit()))
    controller = GameController(team, player, port_offset)
    agent = Agent(name="controlled dribblers", belief=True)
    dribbler = Dribbler(agent.welcome)

    def decide(perception, belief):
        told = controller.game()
        if told is None:
            return {}
        ball = perception["percepts"]["ball"]
        controller.report(fallen=perception["body"] == "fallen", ball=ball and ball["position_m"])
        game = {"state": told["state"], "penalised": told["penalty"] != 0, "stopped": told["is_stopped"]}
        return dribbler.decide({**perception, "game": game}, belief)

    for turn in agent.turns():
        agent.answer(turn, decide(turn["perception"], turn["belief"]))


if __name__ == "__main__":
    main(*(int(word) for word in sys.argv[1:]))
