// A small team: finds the ball, walks around it until it lies before the opponents' goal, shoots, and tells its team-mates. The
// same team as dribblers.py.
//
//     g++ -std=c++17 -O2 clients/cpp/dribblers.cpp -o dribblers && naoisis run match3v3 --blue "exec:./dribblers"
#include "naoisis_agent.hpp"

#include <algorithm>
#include <cmath>

using naoisis::Json;

// How far a robot turns in a cycle at most, degrees.
constexpr double TURN_DEG = 3.0;
// A ball that was seen longer ago is searched, s.
constexpr double LOST_S = 2.0;
constexpr double PI = 3.141592653589793;

struct Place {
    double x, y;
};

double rounded(double number) { return std::floor(1e6 * number + 0.5) / 1e6; }

Place place_of(const Json& place) { return {place[0].number(), place[1].number()}; }

// A place of the team's frame in the frame of the robot: x ahead, y to the left, m.
Place in_robot_frame(Place place, const Json& pose) {
    const double x = place.x - pose[0].number(), y = place.y - pose[1].number();
    const double heading = pose[2].number() * (PI / 180.0);
    const double cos = std::cos(heading), sin = std::sin(heading);
    return {rounded(cos * x + sin * y), rounded(cos * y - sin * x)};
}

// Degrees of a cycle's turn to a place in the robot's frame: fewer if it is nearly ahead.
double turn_towards(Place place) {
    const double turn = place.x > 0.1 ? 30.0 * place.y / place.x : 1e9 * place.y;
    return std::clamp(turn, -TURN_DEG, TURN_DEG);
}

class Dribbler {
public:
    explicit Dribbler(const Json& welcome) {
        const Json& kicks = welcome["model"]["kicks"];
        goal_ = {welcome["field"]["length_m"].number() / 2.0, 0.0};
        const Json& start = welcome["pose"];
        if (!start.is_null()) place_ = {start[0].number(), 0.4 * start[1].number()};
        // Nearly as fast as it can.
        step_m_ = rounded(0.9 * welcome["model"]["motion"]["max_linear_mps"].number() * welcome["cycle_s"].number());
        // Some robots have a kick whose direction is chosen.
        const Json& aimed = kicks["own"]["visual"];
        aims_ = !aimed.is_null();
        const Json& region = (aims_ ? aimed : kicks["left_straight"])["region"];
        if (!region.is_null()) reach_m_ = {0.9 * region["x_m"][1].number(), 0.9 * region["y_m"][1].number()};
        aside_ = aims_ ? 0.8 : 0.15;
    }

    Json decide(const Json& perception, const Json& belief) {
        const std::string state = state_of(perception["game"]);
        const Json& pose = belief["pose"];
        const bool waits = perception["game"]["penalised"].truth() || perception["game"]["stopped"].truth();
        if (waits || (state != "ready" && state != "playing")) return Json::object();
        if (perception["body"].text() == "fallen") return Json::object({{"posture", "get_up"}});
        if (state == "ready") {
            const Place place = in_robot_frame(place_, pose);
            if (place.x * place.x + place.y * place.y > 0.04) {
                const double step_m = place.x > std::abs(place.y) ? step_m_ : 0.0;
                return Json::object({{"walk", {step_m, 0.0, rounded(turn_towards(place))}}});
            }
        }
        if (belief["ball"].is_null() || belief["ball"]["age_s"].number() > LOST_S) {
            // It turns on the spot and looks near, then far.
            return Json::object({{"walk", {0.0, 0.0, TURN_DEG}}, {"head_deg", {0.0, pose[2].number() > 0.0 ? 30.0 : 0.0}}});
        }
        const Place ball = in_robot_frame(place_of(belief["ball"]["position_m"]), pose);
        // It faces the ball: the referee removes robots that stand and look elsewhere.
        if (state == "ready") return Json::object({{"walk", {0.0, 0.0, rounded(0.3 * turn_towards(ball))}}});
        const Place goal = in_robot_frame(goal_, pose);
        // A ball at the feet is seen only with the head down.
        Json command = Json::object({{"head_deg", {0.0, ball.x < 0.5 ? 40.0 : 0.0}}});
        command.set("say", Json::object({{"intention", "dribble"}, {"payload", ball.x < 1.0 ? "near" : "far"}}));
        const bool is_near = 0.0 < ball.x && ball.x < 0.5 && -0.25 < ball.y && ball.y < 0.25;
        const bool faces_goal = goal.x > 0.0 && -aside_ * goal.x < goal.y && goal.y < aside_ * goal.x;
        if (is_near && !faces_goal) {
            // Around the ball, which stays in front.
            const double side = goal.y > 0.0 ? -1.0 : 1.0;
            const double turn = 0.3 * turn_towards(ball) - side * 28.0 * step_m_ / std::max(ball.x, 0.1);
            command.set("walk", {rounded(0.1 * (ball.x - reach_m_.x)), rounded(side * step_m_ / 2.0), rounded(turn)});
        } else if (is_near && ball.x < reach_m_.x && -reach_m_.y < ball.y && ball.y < reach_m_.y) {
            command.set("kick", kick(ball, goal));
        } else if (is_near) {
            // Slowly, and sideways until the ball lies before the robot.
            const double ahead = 0.1 * (ball.x - 0.8 * reach_m_.x), turn = 0.3 * turn_towards(ball);
            command.set("walk", {rounded(ahead), rounded(0.05 * ball.y), rounded(turn)});
        } else {
            command.set("walk", {step_m_, 0.0, rounded(turn_towards(ball))});
        }
        return command;
    }

private:
    Place goal_;
    // Its place for kick-offs: from where it starts, towards the middle of the pitch.
    Place place_ = {-1.0, 0.0};
    // How far it walks in a cycle, m.
    double step_m_;
    bool aims_;
    // How near, and how far to one side, a ball can be kicked, m.
    Place reach_m_ = {0.17, 0.08};
    // How far to one side the goal may be, as a share of its distance.
    double aside_;
    // The state that it was told last, and the numbers of whistles and of signals for `ready` at that time.
    std::string told_;
    double whistles_ = 0.0, signals_ = 0.0;

    // The state of the game: a whistle or a signal of the referee comes before a late report.
    std::string state_of(const Json& game) {
        const std::string& state = game["state"].text();
        const double whistles = game["whistles"].number(), signals = game["ready_signals"].number();
        if (state != told_) {
            told_ = state;
            whistles_ = whistles;
            signals_ = signals;
        }
        if (state == "set" && whistles > whistles_) return "playing";
        return state == "standby" && signals > signals_ ? "ready" : state;
    }

    Json kick(Place ball, Place goal) const {
        if (!aims_) return Json::object({{"type", ball.y > 0.0 ? "left_straight" : "right_straight"}, {"speed", 1.0}});
        const double direction_deg = rounded(std::atan2(goal.y, goal.x) * (180.0 / PI));
        return Json::object({{"type", "visual"}, {"speed", 3.0}, {"direction_deg", direction_deg}});
    }
};

// Plays a robot that is told these parts of its perceptions; all, if none are named.
void play(const std::vector<std::string>& fields) {
    naoisis::Hello hello;
    hello.name = "dribblers";
    hello.belief = true;
    hello.fields = fields;
    naoisis::Agent agent(hello);
    Dribbler dribbler(agent.welcome());
    while (const Json* turn = agent.next()) agent.answer(dribbler.decide((*turn)["perception"], (*turn)["belief"]));
}

int main() {
    play({"body", "game.penalised", "game.state", "game.stopped", "game.whistles", "game.ready_signals"});
}
