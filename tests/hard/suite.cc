#include "hard/suite.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <sstream>

namespace vdbcloud::test {

namespace {

/// What the programs did against the record; empty: nothing.
std::string failure(const World& world, const Seen& seen)
{
    if (world.refused == 0) return seen.failure;
    if (seen.last && seen.status == world.refused && seen.failure.find(world.sentence) != std::string::npos) return {};
    return "expected status " + std::to_string(world.refused) + " and '" + world.sentence +
           "' from the last program: " + (seen.failure.empty() ? "all programs ended with status 0" : seen.failure);
}

}  // namespace

std::vector<Suite::Judged> Suite::judge(const World& world)
{
    std::vector<Judged> all;
    try {
        const Seen seen = world.commands.empty() ? chain_.run(world) : chain_.run_commands(world);
        const std::string bad = failure(world, seen);
        all.push_back({"ends", bad, bad.empty() ? seen.seconds : std::numeric_limits<double>::infinity(), 20});
        if (!bad.empty()) return all;
        for (const auto& [name, limit] : world.holds) {
            const Verdict verdict = judged(chain_, world, seen, name);
            all.push_back({name, verdict.where, verdict.worst, limit});
        }
    } catch (const std::exception& e) {
        all.push_back({"ends", e.what(), std::numeric_limits<double>::infinity(), 20});
    }
    return all;
}

void Suite::note(const std::string& group, const World& world, const std::vector<Judged>& all)
{
    for (const Judged& one : all) {
        const auto known = world.known.find(one.invariant);
        const bool random = group != world.name;
        add_row(rows_,
                {group, one.invariant, one.value, one.limit, 1, one.holds() ? 0 : 1,
                 (random ? world.name + ": " : "") + one.where, known == world.known.end() ? "" : known->second});
        if (!one.holds() && known == world.known.end()) {
            const World small = random ? smallest(world, one.invariant, one.where) : world;
            const Judged again = random ? judge(small).back() : one;
            failures_.push_back({small.text(), one.invariant, again.where, again.value, again.limit});
        }
    }
}

World Suite::smallest(const World& world, const std::string& name, const std::string& words)
{
    World small = world;
    // The invariant alone, as the others cost time; a program may end badly within any of them.
    if (name != "ends")
        small.holds.erase(std::remove_if(small.holds.begin(), small.holds.end(),
                                         [&](const auto& held) { return held.first != name; }),
                          small.holds.end());
    const auto fails = [&](const World& candidate) {
        if (name != "ends" && !invariant(name).applies(candidate)) return false;
        const auto all = judge(candidate);
        return all.back().invariant == name && !all.back().holds() &&
               (name != "ends" || all.back().where.substr(0, 60) == words.substr(0, 60));
    };
    for (bool smaller = true; smaller;) {
        smaller = false;
        for (const World& candidate : simpler_worlds(small))
            if (fails(candidate)) {
                small = candidate;
                smaller = true;
                break;
            }
    }
    return small;
}

void Suite::run_case(const World& world) { note(world.name, world, judge(world)); }

void Suite::run_random(uint64_t seed)
{
    const World world = random_world(seed);
    note("random worlds", world, judge(world));
}

void add_row(std::vector<Row>& rows, const Row& row)
{
    for (Row& old : rows) {
        if (old.group != row.group || old.invariant != row.invariant) continue;
        old.worlds += row.worlds;
        old.failed += row.failed;
        if (!(row.worst <= old.worst)) {
            old.worst = row.worst;
            old.where = row.where;
        }
        return;
    }
    rows.push_back(row);
}

std::string csv(const std::vector<Row>& rows)
{
    std::ostringstream out;
    for (const Row& row : rows) {
        std::string where = row.where;
        std::replace(where.begin(), where.end(), '\t', ' ');
        std::replace(where.begin(), where.end(), '\n', ' ');
        out << row.group << '\t' << row.invariant << '\t' << digits(row.worst) << '\t' << digits(row.limit) << '\t'
            << row.worlds << '\t' << row.failed << '\t' << row.known << '\t' << where << '\n';
    }
    return out.str();
}

std::vector<Row> rows_of_csv(const std::string& text)
{
    std::vector<Row> rows;
    std::istringstream in(text);
    for (std::string line; std::getline(in, line);) {
        std::vector<std::string> cells(1);
        for (const char c : line)
            if (c == '\t' && cells.size() < 8)
                cells.emplace_back();
            else
                cells.back() += c;
        if (cells.size() != 8) continue;
        rows.push_back({cells[0], cells[1], std::stod(cells[2]), std::stod(cells[3]), std::stoi(cells[4]),
                        std::stoi(cells[5]), cells[7], cells[6]});
    }
    return rows;
}

std::string table(const std::vector<Row>& rows)
{
    std::string text = "| case | invariant | worlds | worst | limit | |\n|---|---|---|---|---|---|\n";
    for (const Row& row : rows) {
        char numbers[96];
        std::snprintf(numbers, sizeof numbers, " | %d | %.2g | %.2g | ", row.worlds, row.worst, row.limit);
        std::string verdict = "pass";
        if (row.failed > 0) verdict = row.known.empty() ? "FAIL, " + std::to_string(row.failed) : "known: " + row.known;
        if (row.failed == 0 && !row.known.empty()) verdict = "FAIL: called known, and passes now";
        text += "| " + row.group + " | " + row.invariant + numbers + verdict + " |\n";
    }
    return text;
}

}  // namespace vdbcloud::test
