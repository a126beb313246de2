#include "rungs.h"

#include "shared.h"

#include "vdbcloud/core/error.h"

#include <algorithm>
#include <sstream>
#include <stdexcept>

namespace vdbcloud::app {

namespace {

const std::string own_default = "-", no_part = "none";

bool takes_part(const RungTable& table, const std::string& program, size_t rung)
{
    return std::none_of(table.rows.begin(), table.rows.end(),
                        [&](const RungRow& row) { return row.program == program && row.values[rung] == no_part; });
}

std::string padded(std::string text, size_t width)
{
    text.resize(std::max(text.size() + 1, width), ' ');
    return text;
}

}  // namespace

RungTable read_rungs(const std::string& text)
{
    RungTable table;
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) {
        if (line.empty() || line[0] == '#') continue;
        const auto expect = [&](bool holds) {
            if (!holds) throw std::logic_error("data/rungs.txt: unexpected line: " + line);
        };
        const std::string head = "rung " + std::to_string(table.names.size()) + ": ";
        if (line.rfind(head, 0) == 0) {
            expect(table.rows.empty() && line.size() > head.size());
            table.names.push_back(line.substr(head.size()));
            continue;
        }
        RungRow row;
        std::istringstream words(line);
        words >> row.program >> row.option;
        for (std::string word; words >> word;) row.values.push_back(word);
        expect(row.option.rfind("--", 0) == 0 && !table.names.empty() && row.values.size() == table.names.size());
        table.rows.push_back(row);
    }
    return table;
}

const RungTable& rungs()
{
    static const RungTable table = read_rungs(rung_text());
    return table;
}

std::string shown(const RungTable& table)
{
    constexpr size_t left = 30, column = 7;
    std::string out = padded("  --rung", left);
    for (size_t n = 0; n < table.names.size(); ++n) out += padded(std::to_string(n), column);
    const auto end_line = [&] {
        out.erase(out.find_last_not_of(' ') + 1);
        out += '\n';
    };
    end_line();
    for (const RungRow& row : table.rows) {
        out += padded("  " + row.program + " " + row.option, left);
        for (const std::string& value : row.values) out += padded(value, column);
        end_line();
    }
    for (size_t n = 0; n < table.names.size(); ++n) out += "  " + std::to_string(n) + ": " + table.names[n] + "\n";
    return out;
}

std::string rungs_of(const RungTable& table, const std::string& program)
{
    std::string first, last;
    for (size_t n = 0; n < table.names.size(); ++n)
        if (takes_part(table, program, n)) {
            last = std::to_string(n);
            if (first.empty()) first = last;
        }
    return first + " to " + last;
}

void App::takes_rungs()
{
    Shared& s = *shared_;
    const RungTable& table = rungs();
    const size_t last = table.names.size() - 1;
    s.rung_option = add_option("--rung", s.rung,
                               "rung of the whole chain: sets the options that the table of rungs below names for this "
                               "program, from 0, the cheapest, to " +
                                   std::to_string(last) +
                                   ", the most accurate. An option that is given beats the rung. Give every program "
                                   "the same rung")
                        ->check(within(0, double(last)))
                        ->default_str("")
                        ->scene("accuracy")
                        ->group("Accuracy");
}

bool App::given_beside_rung(const Option& option) const
{
    // A file that --print-config wrote names every option: where it names the rung, too, all its values are in force.
    return option.given() || (option.cli()->count() > 0 && !on_command_line(shared_->rung_option.cli()));
}

void App::apply_rung()
{
    Shared& s = *shared_;
    if (!s.rung_option.declared() || s.rung_option.cli()->count() == 0) return;
    const RungTable& table = rungs();
    const auto rung = size_t(s.rung);
    const std::string asked = place(s.rung_option.cli()) + s.rung_option.text();
    if (!takes_part(table, get_name(), rung))
        throw UsageError(asked + " (" + table.names[rung] + ") needs no " + get_name() +
                         ": hand its input to render --rung " + std::to_string(rung) + ", or take --rung " +
                         rungs_of(table, get_name()));
    nlohmann::json options = nlohmann::json::array();
    for (const RungRow& row : table.rows) {
        if (row.program != get_name() || row.values[rung] == own_default) continue;
        const Option option(*this, get_option(row.option));
        const auto stops = [&](const Rule& rule) { return rule.option == option.cli() && !rule.holds(); };
        const bool useless = std::any_of(s.rules.begin(), s.rules.end(), stops) ||
                             std::any_of(s.rung_rules.begin(), s.rung_rules.end(), stops);
        if (given_beside_rung(option) || useless) continue;
        option.cli()->clear();  // a default that a file of options names
        option.cli()->run_callback_for_default()->default_val(row.values[rung]);
        s.rung_set.push_back(option);
        options.push_back(row.option.substr(2));
    }
    s.report["rung"] = {{"number", rung}, {"name", table.names[rung]}, {"options", options}};
}

std::string App::set_by_rung(const std::string& message) const
{
    std::string all;
    bool named = false;
    for (const Option& option : shared_->rung_set) {
        all += " " + option.text();
        named = named || message.find(option.name()) != std::string::npos;
    }
    return named ? " (" + shared_->rung_option.text() + " sets" + all + ")" : "";
}

}  // namespace vdbcloud::app
