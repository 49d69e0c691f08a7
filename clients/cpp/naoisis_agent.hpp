// Plays a robot of a naoisis match: needs C++17 and the standard library.
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
// trace's `command`. Standard output belongs to the match: print to std::cerr.
#pragma once

#include <cctype>
#include <charconv>
#include <cstdlib>
#include <functional>
#include <initializer_list>
#include <iostream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <variant>
#include <vector>

namespace naoisis {

// A JSON value: null, a truth value, a number, a text, a list or an object. What is not there is null.
class Json {
public:
    using List = std::vector<Json>;
    // The fields in their order: there are so few that looking for one is quicker than keeping them sorted.
    using Object = std::vector<std::pair<std::string, Json>>;

    Json() = default;
    Json(bool value) : value_(value) {}
    Json(int value) : value_(static_cast<double>(value)) {}
    Json(double value) : value_(value) {}
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

// Plays a robot until the match is over. How it ended, with its score; null if the match was broken off. Of what the robot
// perceives `decide` gets the fields that are named, such as "percepts.ball" or "game.state", and all if none is.
inline Json play(const std::function<Json(const Json&)>& decide, const std::string& name = "", const std::vector<std::string>& fields = {}) {
    std::ios::sync_with_stdio(false);
    Json hello = Json::object({{"protocol", 1}, {"name", name}});
    if (!fields.empty()) hello.set("fields", Json(Json::List(fields.begin(), fields.end())));
    std::cout << Json::object({{"hello", hello}}).dump() << '\n' << std::flush;
    std::string answer;
    for (std::string line; std::getline(std::cin, line);) {
        const Json message = Json::parse(line);
        if (!message["end"].is_null()) return message["end"];
        if (!message["refused"].is_null()) throw std::runtime_error(message["refused"]["reason"].text());
        if (message["cycle"].is_null()) continue;
        const Json command = decide(message["perception"]);
        answer = "{\"cycle\":";
        message["cycle"].write(answer);
        answer += ",\"command\":";
        if (command.is_null()) answer += "{}";
        else command.write(answer);
        answer += "}\n";
        std::cout.write(answer.data(), static_cast<std::streamsize>(answer.size())) << std::flush;
    }
    return Json();
}

}  // namespace naoisis
