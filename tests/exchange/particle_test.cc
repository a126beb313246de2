// Particles: what is read of each format, and the mass that splats keep.
#include "vdbcloud/exchange/particles.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/file/io.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/schema.h"

#include "support/damage.h"
#include "support/make_odd.h"
#include "support/run.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>

namespace vdbcloud::test {
namespace {

std::string refusal(const std::function<void()>& work)
{
    try {
        work();
    } catch (const std::exception& e) {
        return e.what();
    }
    return "read";
}

struct Sums {
    double mass = 0;
    Vec3d middle{0, 0, 0};
};

Sums sums_of(const FloatGrid& grid)
{
    Sums sums;
    const Vec3d voxel = grid.voxelSize();
    for (auto v = grid.cbeginValueOn(); v; ++v)
        for (auto at = v.getBoundingBox().begin(); at; ++at) {
            const double mass = double(*v) * voxel[0] * voxel[1] * voxel[2];
            sums.mass += mass;
            sums.middle += mass * grid.indexToWorld(*at);
        }
    sums.middle /= sums.mass;
    return sums;
}

TEST(Splat, KeepsTheMassOfAParticleOfAnyRadiusAnywhere)
{
    Dice dice(3);
    const auto uniform = [&] { return double(dice.bits() >> 11) * 0x1p-53; };
    for (const Vec3d& cell : {Vec3d(1.0), Vec3d(0.5, 0.25, 0.9)})
        for (const double radius : {0.0, 0.01, 0.3, 1.0, 1.99, 2.0, 2.5, 7.0, 12.3})
            for (int k = 0; k < 6; ++k) {
                Particles one;
                // Half of them on the borders of blocks.
                const double border = k % 2 ? 8 : 0.9;
                one.position = {Vec3d(border * cell[0] + 1e-3 * k, -border * cell[1] + uniform(), uniform() - border)};
                one.radius = {float(radius)};
                one.mass = {float(0.1 + 3 * uniform())};
                const Splats splats = splat(one, {cell, 0});
                const Sums sums = sums_of(*splats.density);
                EXPECT_NEAR(sums.mass / double(one.mass[0]), 1, 1e-6) << radius << cell;
                EXPECT_NEAR(splats.mass, double(one.mass[0]), 1e-12);
                // Trilinear weights keep the place; the kernel is sampled at the voxels about it.
                const double off = (sums.middle - one.position[0]).length();
                EXPECT_LT(off, radius < 2 * cell[2] ? 1e-5 : 0.04) << radius << cell;
            }
}

TEST(Splat, KeepsTheMassOfManyParticlesOfUnequalMass)
{
    Dice dice(5);
    const auto uniform = [&] { return double(dice.bits() >> 11) * 0x1p-53; };
    Particles many;
    double mass = 0;
    for (int k = 0; k < 20000; ++k) {
        many.position.emplace_back(4 * uniform(), 4 * uniform(), 4 * uniform());
        many.radius.push_back(float(2 * uniform()));
        // A float beside a thousand times as large a sum would lose the small ones.
        many.mass.push_back(k == 0 ? 1e6f : float(uniform()));
        mass += double(many.mass.back());
    }
    const Splats splats = splat(many, {Vec3d(0.5), 0});
    EXPECT_NEAR(sums_of(*splats.density).mass / mass, 1, 1e-6);
    const SplatWork work = splat_work(many, {Vec3d(0.5), 0});
    std::vector<openvdb::Index32> nodes = splats.density->tree().nodeCount();  // leaves first
    EXPECT_EQ(work.blocks, double(nodes[0]));
    EXPECT_EQ(work.nodes, double(nodes[1]));
}

TEST(Splat, TemperatureAndVelocityAreMeansOverTheMass)
{
    Particles two;
    two.position = {Vec3d(3, 4, 5), Vec3d(3, 4, 5)};
    two.mass = {1, 3};
    two.temperature = {400, 800};
    two.velocity = {Vec3f(4, 0, 0), Vec3f(0, 8, 0)};
    const Splats splats = splat(two, {Vec3d(1.0), 0});
    const openvdb::Coord at(3, 4, 5);
    EXPECT_EQ(splats.density->activeVoxelCount(), 1u);
    EXPECT_EQ(splats.density->tree().getValue(at), 4.0f);
    EXPECT_EQ(splats.temperature->tree().getValue(at), 700.0f);
    EXPECT_EQ(splats.velocity->tree().getValue(at), Vec3f(1, 6, 0));
}

TEST(Splat, TheKernelFallsSmoothlyToTheRadius)
{
    Particles one;
    one.position = {Vec3d(0.0)};
    one.radius = {8};
    const Splats splats = splat(one, {Vec3d(1.0), 0});
    const auto value = [&](int x) { return double(splats.density->tree().getValue({x, 0, 0})); };
    for (int x = 1; x < 8; ++x) {
        const double q = x / 8.0;
        EXPECT_NEAR(value(x) / value(0), std::pow(1 - q, 4) * (4 * q + 1), 1e-6) << x;
    }
    EXPECT_EQ(value(8), 0);
    // 21 / (2 pi r^3) is the kernel's integral over the ball.
    EXPECT_NEAR(value(0), 21 / (2 * M_PI * 512), 1e-3 * value(0));
}

TEST(Splat, DensityOfAParticleTimesItsBallIsItsMass)
{
    Particles one;
    one.position = {Vec3d(0.0)};
    one.density = {2};
    EXPECT_NEAR(sums_of(*splat(one, {Vec3d(1.0), 3}).density).mass, 2 * 4.0 / 3 * M_PI * 27, 1e-4);
    EXPECT_NE(refusal([&] { splat(one, {Vec3d(1.0), 0}); }).find("--radius"), std::string::npos);
    one.position = {Vec3d(1e8, 0, 0)};
    EXPECT_NE(refusal([&] { splat(one, {Vec3d(1.0), 1}); }).find("2^22 voxels"), std::string::npos);
}

constexpr const char* ply_elements =
    "element face 2\nproperty list uchar int corners\nelement vertex 2\nproperty double x\n"
    "property float y\nproperty short z\nproperty float pscale\nproperty uchar tag\n"
    "property float vx\nproperty float vy\nproperty float vz\nend_header\n";

template<typename T>
std::string bytes_of(T value, bool swap)
{
    std::string bytes(reinterpret_cast<const char*>(&value), sizeof value);
    if (swap) std::reverse(bytes.begin(), bytes.end());
    return bytes;
}

std::string binary_ply(bool big)
{
    std::string bytes =
        std::string("ply\nformat binary_") + (big ? "big" : "little") + "_endian 1.0\ncomment made\n" + ply_elements;
    for (int face = 0; face < 2; ++face) {
        bytes += char(face + 1);
        for (int k = 0; k <= face; ++k) bytes += bytes_of<int32_t>(k, big);
    }
    for (int k = 0; k < 2; ++k)
        bytes += bytes_of<double>(0.5 + k, big) + bytes_of<float>(-2.0f * float(k), big) +
                 bytes_of<int16_t>(int16_t(7 - k), big) + bytes_of<float>(0.25f, big) + char(9) +
                 bytes_of<float>(1, big) + bytes_of<float>(2, big) + bytes_of<float>(float(k), big);
    return bytes;
}

void expect_two(const Particles& read, const std::string& what)
{
    ASSERT_EQ(read.position.size(), 2u) << what;
    EXPECT_EQ(read.position[0], Vec3d(0.5, 0, 7)) << what;
    EXPECT_EQ(read.position[1], Vec3d(1.5, -2, 6)) << what;
    EXPECT_EQ(read.radius, (std::vector<float>{0.25f, 0.25f})) << what;
    EXPECT_EQ(read.velocity, (std::vector<Vec3f>{{1, 2, 0}, {1, 2, 1}})) << what;
    EXPECT_TRUE(read.mass.empty() && read.temperature.empty()) << what;
}

TEST(ParticleFiles, PlyAsTextAndBytes)
{
    const Scratch scratch;
    const std::string path = scratch / "a.ply";
    write_text(path, std::string("ply\r\nformat ascii 1.0\n") + ply_elements +
                         "1 0\n2 0 1\n0.5 0 7 0.25 9 1 2 0\n1.5 -2 6 0.25 9 1 2 1\n");
    expect_two(read_ply(path, {}), "ascii");
    for (const bool big : {false, true}) {
        write_text(path, binary_ply(big));
        expect_two(read_ply(path, {}), "binary");
    }
    EXPECT_EQ(read_ply(path, {{"mass", "tag"}}).mass, (std::vector<float>{9, 9}));
    EXPECT_NE(refusal([&] {
                  read_ply(path, {{"mass", "weight"}});
              }).find("'weight': there are x, y, z"),
              std::string::npos);
    int refused = 0;
    for (uint64_t seed = 0; seed < 100; ++seed) {
        Dice dice(seed);
        write_text(path, damaged(binary_ply(false), dice));
        const std::string said = refusal([&] { read_ply(path, {}); });
        refused += said != "read";
        EXPECT_EQ(said.rfind(said == "read" ? "" : path, 0), 0u) << said;
    }
    EXPECT_GT(refused, 30);
}

TEST(ParticleFiles, CsvWithNames)
{
    const Scratch scratch;
    const std::string path = scratch / "a.csv";
    const auto read = [&](const std::string& text, const ParticleNames& names = {}) {
        write_text(path, text);
        return read_csv(path, names);
    };
    expect_two(read("x,y,z,radius,v.x,v.y,v.z\n0.5,0,7,0.25,1,2,0\n# more\n1.5,-2,+6,0.25,1,2,1\n"), "commas");
    expect_two(read("\xef\xbb\xbf\"Points:0\";\"Points:1\";\"Points:2\";pscale;Velocity:0;Velocity:1;Velocity:2\r\n"
                    "0.5;0;7;0.25;1;2;0\r\n1.5;-2;6;0.25;1;2;1\r\n"),
               "semicolons");
    expect_two(read("P[0] P[1] P[2] size u_0 u_1 u.2\n0.5 0 7 .25 1 2 0\n1.5 -2 6 .25 1 2 1",
                    {{"radius", "size"}, {"velocity", "u"}}),
               "blanks");
    const auto refused = [&](const std::string& text, const std::string& words) {
        const std::string said = refusal([&] { read(text); });
        EXPECT_NE(said.find(words), std::string::npos) << said;
        EXPECT_EQ(said.rfind(path, 0), 0u) << said;
    };
    refused("", "empty");
    refused("x,y\n1,2\n", "no columns of the position");
    refused("x,y,z\n1,2\n", "line 2: 2 columns: expected 3");
    refused("x,y,z\n1,2,3\n1,two,3\n", "line 3: 'two' in column 'y'");
    refused("x,y,z,mass\n1,2,3,-1\n", "line 2: mass -1");
    refused("x,y,z\n1,2e10,3\n", "line 2: position");
}

TEST(ParticleFiles, PointsOfOpenVdb)
{
    const Scratch scratch;
    openvdb::initialize();
    GridFile file;
    file.metadata = std::make_shared<MetaMap>();
    file.grids = {particle_grid()};
    const std::string path = scratch / "points.vdb";
    write_grid_file(path, file);
    const Particles read = read_points(path, {});
    ASSERT_EQ(read.position.size(), 2u);
    const size_t first = read.position[0][0] > 0 ? 0 : 1, second = 1 - first;
    EXPECT_NEAR((read.position[first] - Vec3d(1, 2, 3)).length(), 0, 1e-6);
    EXPECT_NEAR((read.position[second] - Vec3d(-4, 0.5, 9)).length(), 0, 1e-6);
    EXPECT_EQ(read.radius[second], 2.0f);
    EXPECT_EQ(read.mass[first], 3.0f);
    EXPECT_EQ(read.velocity[second], Vec3f(0, 0, -2));
    EXPECT_NE(refusal([&] { read_points(path, {{"mass", "v"}}); }).find("no attribute 'v' (mass)"), std::string::npos);

    file.grids = {point_grid()};
    write_grid_file(path, file);
    EXPECT_EQ(read_points(path, {}).position.size(), 3u);
    EXPECT_TRUE(read_points(path, {}).radius.empty());
    const std::string whole = read_text(path);
    for (uint64_t seed = 0; seed < 20; ++seed) {
        Dice dice(seed);
        write_text(path, damaged(whole, dice));
        const std::string said = refusal([&] { read_points(path, {}); });
        EXPECT_EQ(said.rfind(said == "read" ? "" : path, 0), 0u) << said;
    }
    file.grids = {FloatGrid::create()};
    write_grid_file(path, file);
    EXPECT_NE(refusal([&] { read_points(path, {}); }).find("holds no points"), std::string::npos);
}

TEST(ImportParticles, KeepMassUnitsAndBytesOnAnyNumberOfThreads)
{
    const Scratch scratch;
    std::string text = "x,y,z,pscale,mass,temperature,vx,vy,vz\n";
    Dice dice(11);
    const auto uniform = [&] { return std::to_string(double(dice.bits() >> 11) * 0x1p-53); };
    for (int k = 0; k < 3000; ++k) {
        for (int c = 0; c < 9; ++c) text += (c ? "," : "") + uniform();
        text += "\n";
    }
    write_text(scratch / "smoke.csv", text);
    RunOptions there;
    there.folder = scratch.path();
    const std::string line = "vdbimport smoke.csv --cell 0.2,0.2,0.2 --meters-per-unit 2 --extinction 3 -q ";
    const RunResult r = shell(line + "--threads 1 -o one.vdb && " + line + "--threads 2 --json - -o two.vdb", there);
    ASSERT_EQ(r.status, 0) << r.err;
    EXPECT_EQ(read_text(scratch / "one.vdb"), read_text(scratch / "two.vdb"));
    const auto report = nlohmann::json::parse(r.out);
    EXPECT_NEAR(double(report["particles"]["mass_of_grid"]) / double(report["particles"]["mass"]), 1, 1e-6);
    const GridFile file = read_grid_file(scratch / "two.vdb");
    EXPECT_EQ(file.grids.size(), 3u);
    EXPECT_EQ(get_number(*file.metadata, schema::meters_per_unit, 0), 2);
    EXPECT_EQ(get_vector(*find_grid(file, schema::density), schema::sigma_t_per_density, Vec3d(0.0)), Vec3d(3.0));
    write_text(scratch / "bare.csv", "x,y,z\n1,2,3\n");
    const RunResult bare = shell("vdbimport bare.csv -o bare.vdb", there);
    EXPECT_EQ(bare.status, 2);
    EXPECT_NE(bare.err.find("--cell is missing"), std::string::npos) << bare.err;
    EXPECT_EQ(
        shell("vdbimport bare.csv --radius 1 -o bare.vdb && render bare.vdb --resolution 8 -o bare.exr", there).status,
        0);
    EXPECT_EQ(shell("vdbimport smoke.csv --radius 1 -o bare.vdb", there).status, 2) << "no effect";
}

}  // namespace
}  // namespace vdbcloud::test
