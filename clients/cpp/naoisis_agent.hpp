// Plays a robot of a naoisis match: needs C++17 and the standard library, and POSIX sockets for `naoisis serve`.
//
//     #include "naoisis_agent.hpp"
//     using naoisis::Json;
//
//     Json decide(const Json& perception) {
//         const Json& ball = perception["percepts"]["ball"];
//         if (ball.is_null()) return Json::object({{"walk", {0.0, 0.0, 3.0}}});
//         return Json::object({{"walk", {0.006, 0.0, ball["position_m"][1].number() > 0.0 ? 3.0 : -3.0}}});
//     }
//
//     int main() { naoisis::play(decide, "my team"); }
//
//     $ g++ -std=c++17 -O2 my_team.cpp -o my_team && naoisis run match3v3 --blue "exec:./my_team"
//
// `decide` receives the perception of the robot in a cycle, as in a trace, and returns a command with the names of a
// trace's `command`, or a whole answer, which has a `command` and what the program thinks: `belief`, `intention`, `reasons`,
// `drawings` and `values`. Standard output belongs to the match: print to std::cerr.
//
// Programs that want more than perceptions use an Agent:
//
//     naoisis::Hello hello;
//     hello.belief = true;                       // the belief of the built-in estimator
//     naoisis::Agent agent(hello);
//     std::cerr << agent.robot() << '\n';       // also agent.welcome()["model"]["kicks"], ["field"], ["pose"], ...
//     while (const Json* turn = agent.next()) agent.answer(decide((*turn)["perception"], (*turn)["belief"]));
#pragma once

#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <initializer_list>
#include <iostream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#if defined(__unix__) || defined(__APPLE__)
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>
#define NAOISIS_HAS_SOCKETS
#endif

namespace naoisis {

// A JSON value: null, a truth value, a number, a text, a list or an object. What is not there is null.
class Json {
public:
    using List = std::vector<Json>;
    // The fields in their order: there are so few that looking for one is quicker than keeping them sorted.
    using Object = std::vector<std::pair<std::string, Json>>;

    Json() = default;
    Json(bool value) : value_(value) {}
    template <class Number, class = std::enable_if_t<std::is_arithmetic_v<Number> && !std::is_same_v<Number, bool>>>
    Json(Number value) : value_(static_cast<double>(value)) {}
    Json(const char* text) : value_(std::string(text)) {}
    Json(std::string text) : value_(std::move(text)) {}
    Json(std::initializer_list<double> numbers) : value_(List(numbers.begin(), numbers.end())) {}
    explicit Json(List values) : value_(std::move(values)) {}
    static Json object(std::initializer_list<std::pair<std::string, Json>> fields = {}) {
        Json json;
        json.value_ = Object(fields);
        return json;
    }

    bool is_null() const { return std::holds_alternative<std::monostate>(value_); }
    bool truth() const { return get<bool>(); }
    double number() const { return get<double>(); }
    const std::string& text() const { return get<std::string>(); }
    const List& list() const { return get<List>(); }
    const Json& operator[](std::string_view name) const {
        if (const auto* fields = std::get_if<Object>(&value_)) {
            for (const auto& [key, value] : *fields) {
                if (key == name) return value;
            }
        }
        return nothing();
    }
    const Json& operator[](const char* name) const { return (*this)[std::string_view(name)]; }
    const Json& operator[](int index) const { return list().at(static_cast<std::size_t>(index)); }
    // Sets a field of an object.
    Json& set(const std::string& name, Json value) {
        if (is_null()) value_ = Object();
        auto& fields = std::get<Object>(value_);
        for (auto& [key, old] : fields) {
            if (key == name) {
                old = std::move(value);
                return *this;
            }
        }
        fields.emplace_back(name, std::move(value));
        return *this;
    }

    static Json parse(const std::string& text) {
        const char* at = text.c_str();
        Json json;
        json.read(at, at + text.size());
        if (skip(at) != text.c_str() + text.size()) throw std::runtime_error("more than one JSON value");
        return json;
    }
    std::string dump() const {
        std::string text;
        write(text);
        return text;
    }
    // Appends the value to a text.
    void write(std::string& out) const {
        if (const auto* truth = std::get_if<bool>(&value_)) {
            out += *truth ? "true" : "false";
        } else if (const auto* number = std::get_if<double>(&value_)) {
            // JSON has no such numbers, and the match would give up the program.
            if (!std::isfinite(*number)) throw std::runtime_error("a number to send is not finite");
            char digits[32];
            out.append(digits, std::to_chars(digits, digits + sizeof digits, *number).ptr);
        } else if (const auto* text = std::get_if<std::string>(&value_)) {
            write_text(out, *text);
        } else if (const auto* values = std::get_if<List>(&value_)) {
            const char* between = "[";
            for (const Json& value : *values) {
                out += between;
                value.write(out);
                between = ",";
            }
            out += values->empty() ? "[]" : "]";
        } else if (const auto* fields = std::get_if<Object>(&value_)) {
            const char* between = "{";
            for (const auto& [name, value] : *fields) {
                out += between;
                write_text(out, name);
                out += ':';
                value.write(out);
                between = ",";
            }
            out += fields->empty() ? "{}" : "}";
        } else {
            out += "null";
        }
    }

private:
    std::variant<std::monostate, bool, double, std::string, List, Object> value_;

    static const Json& nothing() {
        static const Json null;
        return null;
    }
    template <class T> const T& get() const {
        if (const T* value = std::get_if<T>(&value_)) return *value;
        throw std::runtime_error("a JSON value is not what was expected: " + dump());
    }
    static const char*& skip(const char*& at) {
        while (*at == ' ' || *at == '\t' || *at == '\n' || *at == '\r') ++at;
        return at;
    }
    static bool take(const char*& at, char letter) {
        if (*skip(at) != letter) return false;
        ++at;
        return true;
    }
    static void expect(const char*& at, char letter) {
        if (!take(at, letter)) throw std::runtime_error(std::string("expected `") + letter + "` in JSON");
    }
    // Reads a value into this one, where it stays: what is in it is not moved about.
    void read(const char*& at, const char* end) {
        switch (*skip(at)) {
            case '{': {
                ++at;
                Object& fields = value_.emplace<Object>();
                if (take(at, '}')) break;
                fields.reserve(8);
                do {
                    expect(at, '"');
                    auto& [name, value] = fields.emplace_back();
                    read_text(at, name);
                    expect(at, ':');
                    value.read(at, end);
                } while (take(at, ','));
                expect(at, '}');
                break;
            }
            case '[': {
                ++at;
                List& values = value_.emplace<List>();
                if (take(at, ']')) break;
                values.reserve(3);
                do values.emplace_back().read(at, end);
                while (take(at, ','));
                expect(at, ']');
                break;
            }
            case '"': read_text(++at, value_.emplace<std::string>()); break;
            case 't': read_word(at, "true"), value_ = true; break;
            case 'f': read_word(at, "false"), value_ = false; break;
            case 'n': read_word(at, "null"), value_ = std::monostate(); break;
            default: {
                const auto [after, error] = std::from_chars(at, end, value_.emplace<double>());
                if (error != std::errc()) throw std::runtime_error("this is no JSON");
                at = after;
            }
        }
    }
    static void read_word(const char*& at, std::string_view word) {
        for (const char letter : word) {
            if (*at++ != letter) throw std::runtime_error("this is no JSON");
        }
    }
    static void read_text(const char*& at, std::string& text) {
        while (*at != '"') {
            if (*at == '\0') throw std::runtime_error("a JSON text without an end");
            if (*at != '\\') {
                const char* begin = at;
                while (*at != '"' && *at != '\\' && *at != '\0') ++at;
                text.append(begin, at);
                continue;
            }
            const char letter = at[1];
            at += 2;
            switch (letter) {
                case 'n': text += '\n'; break;
                case 't': text += '\t'; break;
                case 'r': text += '\r'; break;
                case 'b': text += '\b'; break;
                case 'f': text += '\f'; break;
                case 'u': text += utf8(at); break;
                default: text += letter;
            }
        }
        ++at;
    }
    // The naoisis side writes only control characters so: no pairs of surrogates.
    static std::string utf8(const char*& at) {
        const unsigned code = static_cast<unsigned>(std::strtoul(std::string(at, 4).c_str(), nullptr, 16));
        at += 4;
        if (code < 0x80) return {static_cast<char>(code)};
        if (code < 0x800) return {static_cast<char>(0xC0 | code >> 6), static_cast<char>(0x80 | (code & 0x3F))};
        return {static_cast<char>(0xE0 | code >> 12), static_cast<char>(0x80 | (code >> 6 & 0x3F)), static_cast<char>(0x80 | (code & 0x3F))};
    }
    static void write_text(std::string& out, const std::string& text) {
        out += '"';
        for (const char letter : text) {
            if (letter == '"' || letter == '\\') out += '\\';
            out += static_cast<unsigned char>(letter) < 0x20 ? ' ' : letter;
        }
        out += '"';
    }
};

// How a program introduces itself.
struct Hello {
    std::string name;
    // The parts of perceptions that it gets, such as "percepts.ball" or "game.state"; all, if none are named.
    std::vector<std::string> fields;
    // Whether it gets the belief of the built-in estimator.
    bool belief = false;
    // The cameras whose images it gets, in base64.
    std::vector<std::string> images;
    // Where `naoisis serve` listens: "tcp:HOST:PORT" or "unix:PATH"; empty for standard input and output.
    std::string address;
    // The robot that it wants, such as "blue2", by default that of NAOISIS_ROBOT; and the token of the match.
    std::string robot;
    std::string token;
};

// The lines to and from the match.
class Lines {
public:
    explicit Lines(const std::string& address) {
        if (!address.empty()) socket_ = connected(address);
        else std::ios::sync_with_stdio(false);
    }
    Lines(const Lines&) = delete;
    Lines& operator=(const Lines&) = delete;
#ifdef NAOISIS_HAS_SOCKETS
    ~Lines() {
        if (socket_ >= 0) ::close(socket_);
    }
#endif

    bool read(std::string& line) {
        if (socket_ < 0) return static_cast<bool>(std::getline(std::cin, line));
#ifdef NAOISIS_HAS_SOCKETS
        for (;;) {
            const auto end = received_.find('\n');
            if (end != std::string::npos) {
                line.assign(received_, 0, end);
                received_.erase(0, end + 1);
                return true;
            }
            char bytes[4096];
            const auto count = ::recv(socket_, bytes, sizeof bytes, 0);
            if (count <= 0) return false;
            received_.append(bytes, static_cast<std::size_t>(count));
        }
#else
        return false;
#endif
    }
    void write(std::string line) {
        line += '\n';
        if (socket_ < 0) {
            std::cout.write(line.data(), static_cast<std::streamsize>(line.size())) << std::flush;
            return;
        }
#ifdef NAOISIS_HAS_SOCKETS
        for (std::size_t sent = 0; sent < line.size();) {
            const auto count = ::send(socket_, line.data() + sent, line.size() - sent, 0);
            if (count <= 0) return;  // The end is noticed in reading.
            sent += static_cast<std::size_t>(count);
        }
#endif
    }

private:
    int socket_ = -1;
    std::string received_;

    static int connected(const std::string& address) {
#ifdef NAOISIS_HAS_SOCKETS
        const auto port = address.rfind(':');
        if (address.compare(0, 5, "unix:") == 0) {
            sockaddr_un place{};
            place.sun_family = AF_UNIX;
            std::strncpy(place.sun_path, address.c_str() + 5, sizeof place.sun_path - 1);
            const int socket = ::socket(AF_UNIX, SOCK_STREAM, 0);
            if (::connect(socket, reinterpret_cast<const sockaddr*>(&place), sizeof place) == 0) return socket;
        } else if (address.compare(0, 4, "tcp:") == 0 && port > 3) {
            addrinfo wanted{}, *places = nullptr;
            wanted.ai_socktype = SOCK_STREAM;
            const std::string host = address.substr(4, port - 4);
            if (::getaddrinfo(host.c_str(), address.c_str() + port + 1, &wanted, &places) == 0) {
                for (const addrinfo* place = places; place; place = place->ai_next) {
                    const int socket = ::socket(place->ai_family, place->ai_socktype, place->ai_protocol);
                    if (::connect(socket, place->ai_addr, place->ai_addrlen) == 0) {
                        const int yes = 1;
                        ::setsockopt(socket, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
                        ::freeaddrinfo(places);
                        return socket;
                    }
                    ::close(socket);
                }
                ::freeaddrinfo(places);
            }
        }
#endif
        throw std::runtime_error("cannot connect to `" + address + "`; expected tcp:HOST:PORT or unix:PATH of a match");
    }
};

// The connection to the match.
class Agent {
public:
    // Introduces the program. Throws if the match refuses it.
    explicit Agent(const Hello& hello) : lines_(hello.address) {
        const char* of_environment = std::getenv("NAOISIS_ROBOT");
        const std::string robot = hello.robot.empty() && of_environment ? of_environment : hello.robot;
        Json said = Json::object({{"protocol", 1}, {"name", hello.name}});
        if (!hello.fields.empty()) said.set("fields", Json(Json::List(hello.fields.begin(), hello.fields.end())));
        if (!hello.images.empty()) said.set("images", Json(Json::List(hello.images.begin(), hello.images.end())));
        if (hello.belief) said.set("belief", true);
        if (!robot.empty()) said.set("robot", robot);
        if (!hello.token.empty()) said.set("token", hello.token);
        lines_.write(Json::object({{"hello", said}}).dump());
        const Json answer = receive() ? message_ : Json();
        if (!answer["refused"].is_null()) throw std::runtime_error(answer["refused"]["reason"].text());
        if (answer["welcome"].is_null()) throw std::runtime_error("the match has hung up");
        welcome_ = answer["welcome"];
    }

    // What the match tells at the beginning: robot, pose, cycle_s, field, rules, model.
    const Json& welcome() const { return welcome_; }
    // The robot that the program plays, such as "blue2".
    const std::string& robot() const { return welcome_["robot"].text(); }
    // How the match ended, with its score; null before the end, or if it was broken off.
    const Json& end() const { return end_; }

    // The next cycle, with its "time_s", "perception", and "belief", "images" and "refused" commands if there are any. It must
    // be answered. Null after the end.
    const Json* next() {
        while (receive()) {
            end_ = message_["end"];
            if (!end_.is_null()) return nullptr;
            if (!message_["cycle"].is_null()) return &message_;
        }
        return nullptr;
    }
    // Answers the cycle with a command, or with a whole answer, which has a "command".
    void answer(const Json& command) {
        std::string line = "{\"cycle\":";
        message_["cycle"].write(line);
        if (command["command"].is_null()) {
            line += ",\"command\":";
            if (command.is_null()) line += "{}";
            else command.write(line);
            line += '}';
        } else {
            // Its fields follow the cycle.
            const std::string rest = command.dump();
            line += ',';
            line.append(rest, 1, std::string::npos);
        }
        lines_.write(std::move(line));
    }

private:
    Lines lines_;
    Json welcome_, message_, end_;

    bool receive() {
        std::string line;
        if (!lines_.read(line)) return false;
        message_ = Json::parse(line);
        return true;
    }
};

// Plays a robot until the match is over. How it ended, with its score; null if the match was broken off.
inline Json play(const std::function<Json(const Json&)>& decide, const Hello& hello) {
    Agent agent(hello);
    while (const Json* turn = agent.next()) agent.answer(decide((*turn)["perception"]));
    return agent.end();
}

// The same over standard input and output, with a name and the fields that `decide` gets.
inline Json play(const std::function<Json(const Json&)>& decide, const std::string& name = "", const std::vector<std::string>& fields = {}) {
    Hello hello;
    hello.name = name;
    hello.fields = fields;
    return play(decide, hello);
}

}  // namespace naoisis
