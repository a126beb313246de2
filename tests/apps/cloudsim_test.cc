// cloudsim as a user runs it: frames and what is in them, restarts after a kill, plans, refusals.
#include "cloudsim_run.h"

#include "vdbcloud/core/vdb.h"
#include "vdbcloud/file/io.h"
#include "vdbcloud/grid/grid_file.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/registry.h"
#include "vdbcloud/grid/schema.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <functional>
#include <sstream>

namespace vdbcloud::test {
namespace {

TEST(Cloudsim, FramesHoldCloudAboveBoltonSaturation)
{
    const Scratch scratch;
    const RunResult r = cloudsim(with(wet, {"-o", scratch / "new/f.%03d.vdb", "--unpruned", "--log", scratch / "log"}));
    ASSERT_EQ(r.status, 0) << r.err;
    std::istringstream log(read_text(scratch / "log"));
    int lines = 0;
    for (std::string line; std::getline(log, line); ++lines) EXPECT_EQ(nlohmann::json::parse(line)["frame"], lines);
    EXPECT_EQ(lines, 5);
    for (const char* number : {"000", "004"}) {
        const GridFile file = read_grid_file(scratch / ("new/f." + std::string(number) + ".vdb"));
        const auto density = openvdb::gridPtrCast<FloatGrid>(find_grid(file, schema::density));
        const auto temperature = openvdb::gridPtrCast<FloatGrid>(find_grid(file, schema::temperature));
        const auto water = openvdb::gridPtrCast<FloatGrid>(find_grid(file, "qt"));
        ASSERT_TRUE(density && temperature && water);
        EXPECT_EQ(find_grid(file, "vel")->getGridClass(), openvdb::GRID_STAGGERED);
        EXPECT_EQ(density->activeVoxelCount(), 16u * 12 * 20);
        EXPECT_EQ(get_text(*file.metadata, schema::up_axis, ""), "Y");
        EXPECT_NEAR(get_vector(*density, schema::sigma_t_per_density, Vec3d(0, 0, 0))[0], 1.5 * 1.16 / (1000 * 10e-6),
                    1e-9);
        EXPECT_NE(get_text(*file.metadata, "cloudsim:parameters", "").find("theta0 = 300"), std::string::npos);
        std::istringstream levels(get_text(*file.metadata, "cloudsim:pressure", ""));
        std::vector<double> pressure;
        for (double p; levels >> p;) pressure.push_back(p);
        ASSERT_EQ(pressure.size(), 20u);
        double most = 0;
        auto t = temperature->getConstAccessor(), q = water->getConstAccessor();
        for (auto it = density->cbeginValueOn(); it; ++it) {
            const auto at = it.getCoord();
            const double p = pressure[size_t(at.y())], kelvin = double(t.getValue(at));
            const double e = 611.2 * std::exp(17.67 * (kelvin - 273.15) / (kelvin - 29.65)), eps = 287.05 / 461.5;
            const double q_s = eps * e / (p - (1 - eps) * e);
            // Temperature comes rounded to 3e-5 K, saturation has a slope of up to 1.2e-3 1/K.
            ASSERT_NEAR(double(*it), std::max(0.0, double(q.getValue(at)) - q_s), 2e-7) << at;
            most = std::max(most, double(*it));
        }
        EXPECT_GT(most, 1e-4);
        // Height is along file y, from 0: cold above.
        EXPECT_GT(t.getValue({3, 0, 3}), t.getValue({3, 19, 3}) + 10);
        EXPECT_NEAR(density->indexToWorld(openvdb::Coord(0, 0, 0)).y(), 0.5 * 128 * 30 / 20, 1e-9);
    }
}

TEST(Cloudsim, SparseFramesHoldOnlyCloud)
{
    const Scratch scratch;
    ASSERT_EQ(cloudsim(with(wet, {"-o", scratch / "last.vdb", "--up", "z"})).status, 0);
    const GridFile file = read_grid_file(scratch / "last.vdb");
    const auto density = openvdb::gridPtrCast<FloatGrid>(find_grid(file, schema::density));
    for (auto it = density->cbeginValueOn(); it; ++it) ASSERT_GT(*it, 0);
    EXPECT_GT(density->activeVoxelCount(), 10u);
    EXPECT_LT(density->activeVoxelCount(), 16u * 12 * 20 / 2);
    EXPECT_EQ(density->evalActiveVoxelDim().y() <= 12, true);
    EXPECT_EQ(get_text(*file.metadata, schema::up_axis, ""), "Z");
}

TEST(Cloudsim, ResumesAfterKillWithEqualFrames)
{
    const Scratch scratch;
    ASSERT_EQ(cloudsim(with(wet, {"-o", scratch / "a%d.vdb", "--log", scratch / "a.log"})).status, 0);
    const Words kept = with(wet, {"-o", scratch / "b%d.vdb", "--checkpoint", scratch / "state", "--resume",
                                  scratch / "state", "--checkpoint-every", "2", "--log", scratch / "b.log"});
    RunOptions kill;
    kill.until = "frame 3";  // after the checkpoint of frame 2: frame 3 is made, and logged, again
    kill.signal = SIGKILL;
    EXPECT_EQ(cloudsim(kept, kill).status, 128 + SIGKILL);
    EXPECT_EQ(cloudsim(kept).status, 0);
    for (const char* number : {"0", "1", "2", "3", "4"}) {
        const RunResult same = run({program("vdbdiff"), scratch / (std::string("a") + number + ".vdb"),
                                    scratch / (std::string("b") + number + ".vdb")});
        EXPECT_EQ(same.status, 0) << number << ' ' << same.out << same.err;
    }
    EXPECT_EQ(read_text(scratch / "a.log"), read_text(scratch / "b.log"));
    // Another run's checkpoint is refused with the parameter that differs.
    const RunResult other = cloudsim(with(kept, {"--theta0", "299"}));
    EXPECT_EQ(other.status, 2);
    EXPECT_NE(other.err.find("theta0 = 300"), std::string::npos) << other.err;
}

TEST(Cloudsim, RefusesDamagedAndOlderCheckpoints)
{
    const Scratch scratch;
    const std::string state = scratch / "state";
    const Words words = with(wet, {"-o", scratch / "a.vdb", "--checkpoint", state, "--resume", state});
    ASSERT_EQ(cloudsim(words).status, 0);
    const std::string whole = read_text(state);
    EXPECT_EQ(whole.rfind("VDBCLOUD CHECKPOINT 7\n", 0), 0u);
    ASSERT_EQ(cloudsim(words).status, 0) << "the checkpoint is sound";
    const auto refusal = [&](const std::string& bytes) {
        write_text(state, bytes);
        const RunResult r = cloudsim(words);
        EXPECT_EQ(r.status, 1) << r.err;
        return r.err;
    };
    std::string turned = whole;
    turned[whole.size() / 2] ^= 1;
    EXPECT_NE(refusal(turned).find("wrong checksum"), std::string::npos);
    EXPECT_NE(refusal(whole.substr(0, 20000)).find("ends too early"), std::string::npos);
    EXPECT_NE(refusal(whole.substr(0, whole.size() - 1)).find("wrong checksum"), std::string::npos);
    std::string older = whole;
    older[20] = '3';
    EXPECT_NE(refusal(older).find("not a checkpoint of this version of cloudsim: expected"), std::string::npos);
}

TEST(Cloudsim, RefusesEveryOptionWithoutEffectByName)
{
    const Scratch scratch;
    // What was given, the option that changes nothing, what it needs.
    const struct {
        Words words;
        std::string idle, wanted;
    } cases[] = {
        {{"--radiation-kappa", "100"}, "--radiation-kappa", "--radiation"},
        {{"--smagorinsky", "0.2"}, "--smagorinsky", "--subgrid on"},
        {{"--sponge", "0", "--sponge-depth", "0.3"}, "--sponge-depth", "--sponge"},
        {{"--side-relaxation", "30s"}, "--side-relaxation", "--sides open"},
        {{"--side-depth", "3"}, "--side-depth", "--sides open"},
        {{"--no-forcing", "--flux-until", "5min"}, "--flux-until", "--heat-flux or --moisture-flux"},
        {{"--no-forcing", "--floor-map", "none.png"}, "--floor-map", "--heat-flux or --moisture-flux"},
        {{"--momentum", "off", "--viscosity", "1"}, "--viscosity", "--momentum on"},
        {{"--momentum", "off", "--friction-time", "10min"}, "--friction-time", "--momentum on"},
        {{"--momentum", "off", "--sponge", "0.1"}, "--sponge", "--momentum on"},
        {{"--momentum", "off", "--wind-relaxation", "1h"}, "--wind-relaxation", "--momentum on"},
        {{"--momentum", "off", "--momentum-scheme", "upwind"}, "--momentum-scheme", "--momentum on"},
        {{"--buoyancy", "off", "--theta0", "290"}, "--theta0", "--buoyancy on"},
        {{"--moisture", "off", "--rain", "on"}, "--rain", "--moisture on"},
        {{"--moisture", "off", "--radiation", "70"}, "--radiation", "--moisture on"},
        {{"--moisture", "off", "--latent-heat", "on"}, "--latent-heat", "--moisture on"},
        {{"--moisture", "off", "--vapour", "on"}, "--vapour", "--moisture on"},
        {{"--moisture", "off", "--loading", "on"}, "--loading", "--moisture on"},
        {{"--moisture", "off", "--saturation", "height"}, "--saturation", "--moisture on"},
        {{"--moisture", "off", "--latent-heat-of", "2e6"}, "--latent-heat-of", "--moisture on"},
        {{"--moisture", "off", "--rho0", "1"}, "--rho0", "--moisture on"},
        {{"--moisture", "off", "--moisture-flux", "1e-4"}, "--moisture-flux", "--moisture on"},
        {{"--moisture", "off", "--noise-water", "1e-4"}, "--noise-water", "--moisture on"},
        {{"--moisture", "off", "--effective-radius", "1e-5"}, "--effective-radius", "--moisture on"},
        {{"--q-surface", "0.01"}, "--q-surface", "--saturation height"},
        {{"--q-scale-height", "2000"}, "--q-scale-height", "--saturation height"},
        {{"--saturation", "height", "--r-vapour", "460"}, "--r-vapour", "--saturation temperature"},
        {{"--smoke-extinction", "0.1"}, "--smoke-extinction", "--moisture off --dye on"},
        {{"--noise", "0", "--noise-water", "0", "--noise-below", "100"}, "--noise-below", "--noise"},
        {{"--noise", "0", "--noise-water", "0", "--seed", "4"}, "--seed", "--noise"},
        {{"--maccormack", "on"}, "--maccormack", "--huge-dt"},
        {{"--fix-budget", "on"}, "--fix-budget", "--huge-dt"},
        {{"--huge-dt", "--cfl", "0.3"}, "--cfl", "--huge-dt"},
        {{"--huge-dt", "--dt-max", "3"}, "--dt-max", "--huge-dt"},
        {{"--huge-dt", "--time-scheme", "rk2"}, "--time-scheme", "--huge-dt"},
        {{"--huge-dt", "--scalars", "koren"}, "--scalars", "--huge-dt"},
        {{"--huge-dt", "--momentum-scheme", "upwind"}, "--momentum-scheme", "--huge-dt"},
        {{"--checkpoint-every", "3"}, "--checkpoint-every", "--checkpoint"},
    };
    for (const auto& c : cases) {
        const RunResult r = cloudsim(with(c.words, {"-o", scratch / "f%d.vdb"}));
        EXPECT_EQ(r.status, 2) << c.idle << ": " << r.err;
        EXPECT_NE(r.err.find(c.idle + " has no effect with"), std::string::npos) << r.err;
        EXPECT_NE(r.err.find(c.wanted), std::string::npos) << r.err;
        EXPECT_EQ(std::count(r.err.begin(), r.err.end(), '\n'), 1) << r.err;
    }
    const RunResult r = cloudsim({"-o", scratch / "one.vdb", "--first-frame", "3"});
    EXPECT_EQ(r.status, 2);
    EXPECT_NE(r.err.find("--first-frame has no effect without"), std::string::npos) << r.err;
    EXPECT_TRUE(scratch.list().empty());
}

TEST(Cloudsim, DryRunPlansAndWritesNothing)
{
    const Scratch scratch;
    const RunResult r =
        cloudsim({"-o", scratch / "f.%d.vdb", "--dry-run", "--rain", "off", "--moisture", "off", "--json", "-"});
    ASSERT_EQ(r.status, 0) << r.err;
    EXPECT_TRUE(scratch.list().empty());
    EXPECT_NE(r.err.find("off  moisture"), std::string::npos) << r.err;
    EXPECT_NE(r.err.find("on   buoyancy"), std::string::npos);
    EXPECT_GT(nlohmann::json::parse(r.out)["estimate"]["memory_bytes"], 1000);
    // Every value in force is told; one number of cells keeps the box's proportions; what a preset has can be taken
    // back.
    const RunResult paper = run({program("cloudsim"), "--preset", "paper", "--cells", "40", "--friction-time", "never",
                                 "-o", scratch / "f.%d.vdb", "--dry-run", "--verbose"});
    EXPECT_NE(paper.err.find("20 x 20 x 40 cells of 100 x 100 x 100 m"), std::string::npos) << paper.err;
    EXPECT_NE(paper.err.find("friction_time = inf"), std::string::npos) << paper.err;
    EXPECT_NE(paper.err.find("saturation = height"), std::string::npos);
}

TEST(Cloudsim, DryRunCountsTheStepsThatLimitsNeed)
{
    const Scratch scratch;
    // Options, and the steps of two minutes by frames of half a minute: from what limits a step, not from the speed.
    const struct {
        Words words;
        double least, most;
    } cases[] = {
        // Relaxation as fast as a millisecond limits nothing.
        {{"--sponge", "900", "--sides", "open", "--side-relaxation", "0.001s", "--wind-relaxation", "0.001s"}, 4, 40},
        {{"--dt", "0.5"}, 240, 240},
        {{"--huge-dt", "--flux-until", "95s"}, 5, 5},
        // 9/4 0.55 k (2 / 512^2 + 1 / 480^2) a second, and what the wind adds.
        {{"--viscosity", "80000"}, 120 * 9.0 / 4 * 0.55 * 8e4 * (2 / (512. * 512) + 1 / (480. * 480)), 1e9},
        // 600 m/s along both axes with a Courant number of 2/3 / 0.55 in cells of 512 m.
        {{"--wind", "300,300"}, 120 / (2.0 / 3 / 0.55 * 512 / 600), 1e9},
    };
    for (const auto& c : cases) {
        Words words{
            program("cloudsim"), "--cells", "8", "--minutes", "2", "--every", "30s", "--json", "-", "--quiet", "-o",
            scratch / "f%d.vdb"};
        words.insert(words.end(), c.words.begin(), c.words.end());
        words.emplace_back("--dry-run");
        const RunResult plan = run(words);
        words.pop_back();
        const RunResult real = run(words);
        ASSERT_EQ(plan.status + real.status, 0) << c.words[0] << plan.err << real.err;
        const double said = nlohmann::json::parse(plan.out)["estimate"]["steps"];
        const double taken = nlohmann::json::parse(real.out)["counts"]["steps"];
        EXPECT_GE(taken, c.least * 0.99) << c.words[0];
        EXPECT_LE(taken, c.most) << c.words[0];
        EXPECT_LE(said / taken, c.most > 100 ? 1.5 : 10) << c.words[0] << ": said " << said << ", taken " << taken;
        EXPECT_GE(said / taken, c.most > 100 ? 1 / 1.5 : 0.1) << c.words[0] << ": said " << said << ", taken " << taken;
    }
}

TEST(Cloudsim, WarnsOfWindAboveMachAThird)
{
    const Scratch scratch;
    const auto warned = [&](const std::string& wind) {
        const RunResult r = run({program("cloudsim"), "--cells", "6", "--moisture", "off", "--minutes", "0", "--wind",
                                 wind, "-o", scratch / "f.vdb"});
        EXPECT_EQ(r.status, 0) << r.err;
        return r.err.find("neglect compression, which matters above Mach 0.3") != std::string::npos;
    };
    EXPECT_TRUE(warned("150,0"));
    EXPECT_FALSE(warned("80,0"));
}

TEST(Cloudsim, StrictEndsWithStatusThreeWhenAnInvariantBreaks)
{
    const Scratch scratch;
    // Transport without a limiter digs below zero beside a wet bubble in dry air.
    const Words dry{"--sounding", "smoke",  "--bubble",    "2000,2000,1200,400,300,3,1e-2",
                    "--scalars",  "plain5", "--no-forcing"};
    const RunResult warned = cloudsim(with(dry, {"-o", scratch / "a%d.vdb"}));
    EXPECT_EQ(warned.status, 0);
    EXPECT_NE(warned.err.find("below 0"), std::string::npos) << warned.err;
    EXPECT_EQ(cloudsim(with(dry, {"-o", scratch / "b%d.vdb", "--strict"})).status, 3);
}

TEST(Cloudsim, EveryPresetRuns)
{
    for (const std::string preset :
         {"cumulus", "congestus", "stratocumulus", "fog", "smoke", "bomex", "rico", "paper"}) {
        const Scratch scratch;
        const RunResult r = run({program("cloudsim"), "--preset", preset, "--cells", "12,10,16", "--minutes", "1",
                                 "--every", "30s", "-o", scratch / "f%d.vdb", "--strict"});
        EXPECT_EQ(r.status, 0) << preset << ": " << r.err;
        EXPECT_EQ(scratch.list().size(), 3u);
    }
}

TEST(Cloudsim, AccuracyBeatsTheSchemesOfThePreset)
{
    const auto parameters = [](const Words& words) {
        const Scratch scratch;
        const RunResult r = run(
            with(with({program("cloudsim")}, words), {"--minutes", "0.1", "--every", "6s", "-o", scratch / "f.vdb"}));
        EXPECT_EQ(r.status, 0) << r.err;
        return "\n" + get_text(*read_grid_file(scratch / "f.vdb").metadata, schema::sim_parameters, "");
    };
    const auto holds = [&](const std::string& all, const Words& lines) {
        for (const std::string& line : lines) EXPECT_NE(all.find("\n" + line + "\n"), std::string::npos) << line << all;
    };
    // The paper's: forward differences, steps of a second.
    const Words own{"--preset", "paper"};
    holds(parameters(own), {"time_scheme = euler", "scalar_scheme = upwind", "momentum_scheme = upwind", "dt = 1"});
    holds(
        parameters(with(own, {"--accuracy", "default"})),
        {"time_scheme = rk3", "scalar_scheme = limited5", "momentum_scheme = upwind5", "dt = 0", "precision = float"});
    holds(
        parameters(with(own, {"--accuracy", "accurate"})),
        {"time_scheme = rk3", "scalar_scheme = limited5", "momentum_scheme = upwind5", "dt = 0", "precision = double"});
    holds(parameters(with(own, {"--accuracy", "small"})),
          {"time_scheme = rk2", "scalar_scheme = koren", "momentum_scheme = upwind5", "dt = 0"});
    holds(parameters(with(own, {"--accuracy", "accurate", "--time-scheme", "euler"})),
          {"time_scheme = euler", "scalar_scheme = limited5"});
}

TEST(Cloudsim, RefusesInOneSentence)
{
    const Scratch scratch;
    const auto refused = [&](const Words& words) {
        const RunResult r = cloudsim(with(words, {"-o", scratch / "f%d.vdb"}));
        EXPECT_EQ(std::count(r.err.begin(), r.err.end(), '\n'), 1) << r.err;
        return r.status;
    };
    EXPECT_EQ(refused({"--preset", "nimbus"}), 2);
    EXPECT_EQ(refused({"--cells", "0"}), 2);
    EXPECT_EQ(refused({"--every", "10 parsecs"}), 2);
    EXPECT_EQ(refused({"--patch", "1,2"}), 2);
    EXPECT_EQ(refused({"--friction-time", "0"}), 2);
    EXPECT_EQ(refused({"--grids", "densty"}), 2);
    EXPECT_EQ(refused({"--grids", "density,rain"}), 2);
    EXPECT_EQ(refused({"--fix-budget", "on"}), 2);
    EXPECT_EQ(refused({"--sponge", "2000"}), 2);
    EXPECT_EQ(refused({"--cfl", "0.8"}), 2);
    EXPECT_EQ(refused({"--sounding", scratch / "none.txt"}), 1);
    EXPECT_EQ(refused({"--init", scratch / "none.vdb"}), 1);
    EXPECT_EQ(refused({"--forcing", scratch / "none.txt"}), 1);
    EXPECT_EQ(refused({"--friction-velocity", "0.3", "--surface-drag", "1e-3"}), 1);
    EXPECT_EQ(refused({"--average", "1h"}), 2);
    EXPECT_EQ(run({program("cloudsim"), "-o", scratch / "f%x.vdb"}).status, 2);
    EXPECT_TRUE(scratch.list().empty());
}

}  // namespace
}  // namespace vdbcloud::test
