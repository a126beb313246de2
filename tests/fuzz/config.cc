#include "fuzz.h"

#include "config.h"

#include "app.h"

#include <sstream>

namespace vdbcloud::test {
namespace {

/// A program with an option of each kind.
struct Tool : app::App {
    double number = 1;
    int whole = 1;
    bool flag = false;
    std::string text, choice = "a";
    Vec3d vector{0, 1, 0};
    std::vector<Vec3d> vectors;
    std::vector<std::string> names;
    Tool() : App("fuzz", "reads configurations")
    {
        add_option("--number", number, "a number");
        add_option("--whole", whole, "a whole number");
        add_flag("--flag,!--no-flag", flag, "a switch");
        add_option("--text", text, "text");
        add_option("--vector", vector, "a vector");
        add_option("--vectors", vectors, "vectors");
        add_option("--name", names, "texts");
        add_choice<std::string>("--choice", choice, {{"a", "a"}, {"b", "b"}}, "one of two words");
        set_config("--config")->add_result("c.toml");
    }
};

}  // namespace

void judge(std::string_view bytes)
{
    static const Tool tool;
    std::istringstream in{std::string(bytes)};
    for (const CLI::ConfigItem& item : app::Toml(tool).from_config(in)) {
        demand(item.parents.empty(), "no tables");
        demand(tool.get_option_no_throw("--" + item.name) != nullptr, "the name of an option");
    }
}

}  // namespace vdbcloud::test
