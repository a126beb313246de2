// The tables of --series and --profiles: what they hold, and that a run that continues completes them.
#include "cloudsim_run.h"

#include "vdbcloud/exchange/netcdf_file.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <sstream>

namespace vdbcloud::test {
namespace {

/// Trade winds on few cells. Options of `more` follow.
RunResult winds(const Scratch& scratch, const std::string& minutes, const Words& more)
{
    return run(with({program("cloudsim"), "--preset", "bomex", "--cells", "8,6,10", "--minutes", minutes, "--every",
                     "30s", "-o", scratch / "f.vdb"},
                    more));
}

/// Lines of numbers by their headings.
std::vector<std::map<std::string, double>> table(const std::string& text)
{
    std::istringstream lines(text);
    std::vector<std::string> names;
    std::vector<std::map<std::string, double>> rows;
    for (std::string line; std::getline(lines, line);) {
        std::istringstream cells(line);
        std::map<std::string, double> row;
        size_t n = 0;
        for (std::string cell; std::getline(cells, cell, ',');) {
            if (rows.empty() && names.size() == n && row.empty() && !std::isdigit(cell[0]))
                names.push_back(cell), ++n;
            else
                row[names.at(n++)] = std::stod(cell);
        }
        if (!row.empty()) rows.push_back(row);
    }
    return rows;
}

TEST(CloudsimForcing, FoldersDoNotHideNamesOfTables)
{
    const Scratch scratch;
    RunOptions there;
    there.folder = scratch / "";
    const RunResult r = shell("mkdir bomex cumulus && cloudsim -q --cells 6 --minutes 0.1 --forcing bomex --sounding "
                              "cumulus -o f.vdb",
                              there);
    EXPECT_EQ(r.status, 0) << r.err;
    EXPECT_EQ(shell("mkdir other && cloudsim -q --cells 6 --forcing other -o f.vdb", there).status, 1);
}

TEST(CloudsimStatistics, ProfilesAreMeansOfTheirPeriods)
{
    const Scratch scratch;
    ASSERT_EQ(
        winds(scratch, "2", {"--series", scratch / "s.csv", "--profiles", scratch / "each.csv", "--average", "30s"})
            .status,
        0);
    ASSERT_EQ(winds(scratch, "2", {"--profiles", scratch / "means.csv", "--average", "1min"}).status, 0);
    ASSERT_EQ(winds(scratch, "2", {"--profiles", scratch / "whole.csv"}).status, 0);
    const auto each = table(read_text(scratch / "each.csv")), means = table(read_text(scratch / "means.csv")),
               whole = table(read_text(scratch / "whole.csv")), series = table(read_text(scratch / "s.csv"));
    ASSERT_EQ(each.size(), 40u);
    ASSERT_EQ(means.size(), 20u);
    ASSERT_EQ(whole.size(), 10u);
    ASSERT_EQ(series.size(), 5u);  // the start, too
    for (size_t k = 0; k < 10; ++k) {
        const auto &first = means[k], &second = means[10 + k];
        EXPECT_EQ(first.at("samples"), 2);
        EXPECT_EQ(second.at("time_start[s]"), 60);
        EXPECT_EQ(second.at("time_end[s]"), 120);
        EXPECT_EQ(whole[k].at("samples"), 4);
        EXPECT_NEAR(first.at("z[m]"), 300 * (double(k) + 0.5), 1e-9);
        for (const auto& [name, value] : first) {
            if (name.find("time") == 0 || name == "samples") continue;
            const double a = each[k].at(name), b = each[10 + k].at(name);
            EXPECT_NEAR(value, (a + b) / 2, 1e-8 * (std::abs(a) + std::abs(b))) << name;
        }
    }
    EXPECT_NEAR(each[0].at("subgrid_w_theta_l[K m/s]"), 8e-3, 1e-8);
    EXPECT_NEAR(each[0].at("theta_l[K]"), 298.7, 0.2);
    EXPECT_NEAR(series[4].at("friction_velocity[m/s]"), 0.28, 1e-3);
    EXPECT_EQ(series[4].at("time[s]"), 120);
}

/// The file has the numbers of whole.s.csv and whole.p.csv.
void expect_netcdf(const Scratch& scratch, const std::string& name)
{
    const NetcdfFile file(scratch / name);
    const auto values = [&](const char* variable) {
        const NetcdfVariable* v = file.variable(variable);
        EXPECT_TRUE(v) << variable;
        if (!v) return std::vector<float>();
        std::vector<size_t> count;
        for (const int d : v->dimensions) count.push_back(file.dimensions()[size_t(d)].length);
        return file.floats(*v, std::vector<size_t>(count.size(), 0), count);
    };
    EXPECT_EQ(file.variable("q_t")->attribute("units"), "kg/kg");
    EXPECT_EQ(file.variable("cloud_cover")->attribute("units"), "1");
    EXPECT_EQ(file.dimensions()[size_t(file.variable("w2")->dimensions[1])].name, "z_face");
    const auto lines = table(read_text(scratch / "whole.p.csv")), series = table(read_text(scratch / "whole.s.csv"));
    const auto q_t = values("q_t"), w2 = values("w2"), time = values("time"), end = values("time_end");
    ASSERT_EQ(q_t.size(), 30u);
    ASSERT_EQ(end.size(), 3u);
    ASSERT_EQ(time.size(), series.size());
    for (size_t n = 0; n < 30; ++n) {
        EXPECT_FLOAT_EQ(q_t[n], float(lines[n].at("q_t[kg/kg]")));
        EXPECT_FLOAT_EQ(w2[n], float(lines[n].at("w2[m^2/s^2]")));
        EXPECT_EQ(end[n / 10], lines[n].at("time_end[s]"));
    }
    EXPECT_EQ(time.back(), 180);
    EXPECT_EQ(values("z_face")[3], 900);
}

TEST(CloudsimStatistics, ARunThatContinuesCompletesTheTables)
{
    const Scratch scratch;
    const auto tables = [&](const std::string& name) {
        return Words{"--average",  "1min",
                     "--series",   scratch / (name + ".s.csv"),
                     "--profiles", scratch / (name + ".p.csv"),
                     "--netcdf",   scratch / (name + ".nc")};
    };
    ASSERT_EQ(winds(scratch, "3", with(tables("whole"), {"--threads", "1"})).status, 0);
    // Half a period after a checkpoint: its lines are of the shorter run, and give way.
    const Words state{"--checkpoint", scratch / "state", "--resume", scratch / "state", "--threads", "2"};
    ASSERT_EQ(winds(scratch, "1.5", with(tables("parts"), state)).status, 0);
    EXPECT_EQ(table(read_text(scratch / "parts.p.csv")).size(), 20u);
    // A run that was stopped after its checkpoint leaves lines of later times: they give way, too.
    const std::string lines = read_text(scratch / "parts.s.csv"),
                      last = lines.substr(lines.rfind('\n', lines.size() - 2));
    write_text(scratch / "parts.s.csv", lines + "100" + last.substr(last.find(',')));
    ASSERT_EQ(winds(scratch, "3", with(tables("parts"), state)).status, 0);
    for (const char* end : {".s.csv", ".p.csv"})
        EXPECT_EQ(read_text(scratch / ("whole" + std::string(end))), read_text(scratch / ("parts" + std::string(end))));
    expect_netcdf(scratch, "whole.nc");
    expect_netcdf(scratch, "parts.nc");
    // The same command again has nothing to add.
    ASSERT_EQ(winds(scratch, "3", with(tables("parts"), state)).status, 0);
    EXPECT_EQ(read_text(scratch / "whole.p.csv"), read_text(scratch / "parts.p.csv"));
    const RunResult other =
        winds(scratch, "4", with(state, {"--profiles", scratch / "parts.p.csv", "--average", "30s"}));
    EXPECT_EQ(other.status, 2);
    EXPECT_NE(other.err.find("averaged over 60"), std::string::npos) << other.err;
}

}  // namespace
}  // namespace vdbcloud::test
