// The suite of hard cases as a program. `make -C tests hard` calls it.
//
//   hard cases FILE [NAME ...]     the cases of a file, or those of these names
//   hard worlds FIRST LAST         random worlds by seed
//   hard world SEED                prints the record of one random world
//   hard hostile TOOL FIRST LAST   hostile files to a program by seed; TOOL all: to every program
//   hard mutant TOOL SEED FOLDER   writes one hostile file and prints the command that reads it
//   hard soak FRAMES               frames through the whole chain: growth of memory, descriptors and files
//   hard table FILE.csv ...        adds up rows and prints the table; status 1 if a row fails
//
// Cases and worlds print their rows to standard output, tab-separated, and failures to standard error.
#include "hard/hostile.h"
#include "hard/soak.h"
#include "hard/suite.h"

#include <cstdio>
#include <iostream>

using namespace vdbcloud::test;

namespace {

template<typename Run>
int finish(const Run& suite, const Programs& programs)
{
    std::cout << csv(suite.rows());
    for (const Failure& failure : suite.failures())
        std::cerr << "\n# " << failure.invariant << " " << failure.value << ", limit " << failure.limit << ": "
                  << failure.where << "\n"
                  << failure.world;
    std::fprintf(stderr, "%d runs of programs, %.1f processor seconds\n", programs.runs(), programs.seconds());
    bool good = true;
    for (const Row& row : suite.rows()) good = good && row.passes();
    return good ? 0 : 1;
}

int run_command(const Words& words)
{
    const auto word = [&](size_t k) { return k < words.size() ? words[k] : std::string(); };
    Programs programs;
    const Scratch scratch;
    Suite suite(programs, scratch.path());
    if (word(0) == "cases") {
        for (const World& world : read_worlds(word(1)))
            if (words.size() == 2 || std::find(words.begin() + 2, words.end(), world.name) != words.end())
                suite.run_case(world);
        return finish(suite, programs);
    }
    if (word(0) == "worlds") {
        for (uint64_t seed = std::stoull(word(1)); seed <= std::stoull(word(2)); ++seed) {
            const double before = programs.seconds();
            suite.run_random(seed);
            if (programs.seconds() - before > 0.5)
                std::fprintf(stderr, "seed %llu took %.1f processor seconds\n", static_cast<unsigned long long>(seed),
                             programs.seconds() - before);
        }
        return finish(suite, programs);
    }
    if (word(0) == "world") {
        std::cout << random_world(std::stoull(word(1))).text();
        return 0;
    }
    if (word(0) == "hostile") {
        Hostile hostile(programs, scratch.path());
        for (const std::string& tool : Hostile::tools())
            if (word(1) == tool || word(1) == "all")
                for (uint64_t seed = std::stoull(word(2)); seed <= std::stoull(word(3)); ++seed)
                    hostile.run(tool, seed);
        return finish(hostile, programs);
    }
    if (word(0) == "mutant") {
        std::cout << Hostile(programs, word(3)).keep(word(1), std::stoull(word(2))) << "\n";
        return 0;
    }
    if (word(0) == "soak") {
        const std::vector<Row> rows = soak(std::stoi(word(1)), scratch.path());
        std::cout << csv(rows);
        for (const Row& row : rows)
            if (!row.passes())
                std::cerr << row.group << ", " << row.invariant << ": " << row.worst << ": " << row.where << "\n";
        return std::all_of(rows.begin(), rows.end(), [](const Row& row) { return row.passes(); }) ? 0 : 1;
    }
    if (word(0) == "table") {
        std::vector<Row> rows;
        for (size_t k = 1; k < words.size(); ++k)
            for (const Row& row : rows_of_csv(read_text(words[k]))) add_row(rows, row);
        std::cout << table(rows);
        return std::all_of(rows.begin(), rows.end(), [](const Row& row) { return row.passes(); }) ? 0 : 1;
    }
    std::cerr << "hard: expected cases, worlds, world, hostile, mutant, soak or table\n";
    return 2;
}

}  // namespace

int main(int argc, char** argv)
{
    try {
        return run_command({argv + 1, argv + argc});
    } catch (const std::exception& e) {
        std::cerr << "hard: " << e.what() << "\n";
        return 2;
    }
}
