// A small team: finds the ball, dribbles it, shoots, and tells its team-mates. The same team as dribblers.py.
//
//     g++ -std=c++17 -O2 clients/cpp/dribblers.cpp -o dribblers && naoisis run match3v3 --blue "exec:./dribblers"
#include "naoisis_agent.hpp"

#include <optional>

using naoisis::Json;

// How far a robot walks and turns in a cycle, m and degrees.
constexpr double STEP_M = 0.006;
constexpr double TURN_DEG = 3.0;
// A ball this near, and this far to one side, can be kicked.
constexpr double REACH_M = 0.17;
constexpr double FOOT_M = 0.08;

struct Place {
    double x, y;
};

Place place_of(const Json& seen) { return {seen["position_m"][0].number(), seen["position_m"][1].number()}; }

// The middle between the posts of the goal that is attacked, m, as far as they are seen.
std::optional<Place> opponents_goal(const Json& perception) {
    const char* colour = perception["game"]["own_end"].text() == "negative_x" ? "yellow" : "blue";
    double x = 0.0, y = 0.0;
    int count = 0;
    for (const Json& post : perception["percepts"]["goal_posts"].list()) {
        if (post["colour"].text() != colour) continue;
        x += place_of(post).x;
        y += place_of(post).y;
        ++count;
    }
    if (count == 0) return std::nullopt;
    return Place{x / count, y / count};
}

// Degrees of a cycle's turn to a place in the robot's frame.
double turn_towards(Place place) {
    if (place.x > 0.0 && -0.1 * place.x < place.y && place.y < 0.1 * place.x) return 0.0;
    return place.y > 0.0 ? TURN_DEG : -TURN_DEG;
}

Json decide(const Json& perception) {
    const Json& game = perception["game"];
    if (game["penalised"].truth() || game["state"].text() != "playing") return Json::object();
    if (perception["body"].text() == "fallen") return Json::object({{"posture", "get_up"}});
    const Json& seen = perception["percepts"]["ball"];
    if (seen.is_null()) return Json::object({{"walk", {0.0, 0.0, TURN_DEG}}, {"head_deg", {0.0, 15.0}}});
    const Place ball = place_of(seen);
    const Json say = Json::object({{"intention", "dribble"}, {"payload", ball.x < 1.0 ? "near" : "far"}});
    // A ball at the feet is seen only with the head down.
    const Json head = {0.0, ball.x < 0.5 ? 25.0 : 0.0};
    const auto goal = opponents_goal(perception);
    if (ball.x < REACH_M && -FOOT_M < ball.y && ball.y < FOOT_M) {
        if (goal && turn_towards(*goal) == 0.0) {
            const char* foot = ball.y > 0.0 ? "left_straight" : "right_straight";
            return Json::object({{"kick", Json::object({{"type", foot}, {"speed", 1.0}})}, {"head_deg", head}, {"say", say}});
        }
        if (!goal) {
            // Around the ball, until the goal comes into view.
            return Json::object({{"walk", {0.0, STEP_M / 2.0, -TURN_DEG}}, {"head_deg", {0.0, 0.0}}, {"say", say}});
        }
    }
    return Json::object({{"walk", {STEP_M, 0.0, turn_towards(ball)}}, {"head_deg", head}, {"say", say}});
}

int main() {
    naoisis::play(decide, "dribblers", {"body", "game.own_end", "game.penalised", "game.state", "percepts.ball", "percepts.goal_posts"});
}
