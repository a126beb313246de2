// Several files in one command: illuminate and p1solve make one medium of them, render lets each shade the others.
#include "several_inputs.h"

namespace vdbcloud::test {
namespace {

Vec3SGridPtr vectors(const GridFile& file, const std::string& name)
{
    return openvdb::gridPtrCast<Vec3SGrid>(find_grid(file, name));
}

TEST_F(SeveralInputs, RenderShowsEachInTheShadowOfTheOthers)
{
    write("low.vdb", body(1));
    write("high.vdb", moved(body(2), Vec3d(0, 4, 0)));
    write("turned.vdb", moved(body(3), Vec3d(0.1, 2.2, 0.2), 0.2), 3);
    for (const char* light : {"--sun 0,1,0", "--sun 0.05,1,0.1 --sun-diameter 8", "--lamp 0.8,9,0.8"}) {
        const double alone = mean("low.vdb", light);
        for (const char* inputs : {"high.vdb low.vdb", "low.vdb turned.vdb", "turned.vdb low.vdb high.vdb"}) {
            const double grids = mean(inputs, light), rays = mean(inputs, std::string(light) + " --shadow-rays");
            // The depth of a shadow varies by 0.3 between voxels of clumpy bodies; the mean of 16^2 columns by 2 %. Of
            // a disc -log T bends where its parts are shaded one by one: 5 % of what the penumbra lets through.
            const double most = std::string(light).find("diameter") == std::string::npos ? 0.02 : 0.05;
            EXPECT_NEAR(grids / rays, 1, most) << inputs << light;
            EXPECT_GT(alone / grids, 1.8) << inputs << light;
        }
    }
}

TEST_F(SeveralInputs, RenderTakesTheLightOfTheInputsWhereNoneShadesAnother)
{
    write("low.vdb", body(1));
    write("beside.vdb", moved(body(2), Vec3d(30, 0, 0)));
    done("illuminate", "-q low.vdb --sun 0,1,0 --refine 2 --fidelity exact -o a.vdb");
    done("illuminate", "-q beside.vdb --sun 0,1,0 -o b.vdb");
    EXPECT_EQ(mean("a.vdb b.vdb", ""), mean("a.vdb", ""));
    EXPECT_NE(mean("low.vdb beside.vdb", "--sun 0,1,0"), mean("a.vdb", ""));
}

TEST_F(SeveralInputs, RenderComputesLightAgainThatWasComputedApart)
{
    write("low.vdb", body(1));
    write("high.vdb", moved(body(2), Vec3d(0, 4, 0)));
    done("illuminate", "-q low.vdb --sun 0,1,0 -o l.vdb");
    done("illuminate", "-q high.vdb --sun 0,1,0 -o h.vdb");
    EXPECT_EQ(mean("l.vdb h.vdb", ""), mean("low.vdb high.vdb", "--sun 0,1,0"));
    EXPECT_LT(mean("l.vdb h.vdb", ""), 0.5 * mean("l.vdb", ""));
}

TEST_F(SeveralInputs, RenderComputesLightAgainThatNamesNoDensity)
{
    // Light of the lower half of a body, without the fingerprint of its density: the upper half is not lit by it.
    const auto half = body(1), whole = body(1, 32);
    write("half.vdb", half);
    done("illuminate", "-q half.vdb --sun 0,1,0 -o lit.vdb");
    write("whole.vdb", whole);
    const auto light = find_grid(read_grid_file(path("lit.vdb")), "transmittance_sun");
    light->removeMeta(schema::density_digest);
    write("edited.vdb", whole, 6, 0.9, 0, {}, {light});
    const std::string said = done("render", "edited.vdb --resolution 8 -o a.exr");
    EXPECT_NE(said.find("has no fingerprint of its density"), std::string::npos) << said;
    EXPECT_EQ(mean("edited.vdb", ""), mean("whole.vdb", "--sun 0,1,0"));
}

TEST_F(SeveralInputs, AreSolvedAsTheFileOfTheirSum)
{
    const auto a = body(1), b = body(2), sum = a->deepCopy();
    for (auto v = sum->beginValueOn(); v; ++v) v.setValue(*v + b->tree().getValue(v.getCoord()));
    write("a.vdb", a);
    write("b.vdb", b);
    write("sum.vdb", sum);
    const std::string options = " -q --sun 0.3,1,0.2 --lamp 0.8,3,0.8";
    done("illuminate", "a.vdb b.vdb -o l.vdb" + options);
    done("illuminate", "sum.vdb -o ls.vdb" + options);
    EXPECT_TRUE(equal("l.vdb", "ls.vdb"));
    done("p1solve", "a.vdb b.vdb -o p.vdb --iterations 2 --directions 24" + options);
    done("p1solve", "sum.vdb -o ps.vdb --iterations 2 --directions 24" + options);
    EXPECT_TRUE(equal("p.vdb", "ps.vdb"));
    done("p1solve", "-q l.vdb -o chain.vdb --iterations 2 --directions 24");
    EXPECT_TRUE(equal("p.vdb", "chain.vdb"));
    done("p1solve", "--threads 1 b.vdb a.vdb -o swapped.vdb --iterations 2 --directions 24" + options);
    EXPECT_TRUE(equal("p.vdb", "swapped.vdb"));
    EXPECT_FALSE(equal("p.vdb", "l.vdb"));
    EXPECT_EQ(mean("p.vdb", ""), mean("ps.vdb", ""));
}

TEST_F(SeveralInputs, P1OfABodyInTheShadowIsDimmerByTheTransmittance)
{
    // A slab of depth 10 x 0.1 x 1.2 above a body, wider than the body by more than its fringe. P1 exchanges nothing
    // across the void, so phi of the body is that of the body alone times exp(-1.2), to the solver's tolerance.
    const auto low = body(1, 8);
    const auto slab = moved(box({32, 10, 32}, edge, [](Coord) { return 1.0; }), Vec3d(-0.8, 6, -0.8));
    write("low.vdb", low, 6);
    write("slab.vdb", slab, 1.2);
    done("p1solve", "-q low.vdb --sun 0,1,0 --tolerance 1e-8 -o alone.vdb");
    done("p1solve", "-q low.vdb slab.vdb --sun 0,1,0 --tolerance 1e-8 -o both.vdb");
    const GridFile alone = read_grid_file(path("alone.vdb")), both = read_grid_file(path("both.vdb"));
    const auto phi = fluence(read_collided_light(alone, PhaseFunction(), {})),
               joined = fluence(read_collided_light(both, PhaseFunction(), {}));
    ASSERT_TRUE(phi && joined);
    for (auto v = low->cbeginValueOn(); v; ++v) {
        const double of_alone = phi->tree().getValue(v.getCoord())[0];
        EXPECT_GT(of_alone, 0);
        EXPECT_NEAR(joined->tree().getValue(v.getCoord())[0] / of_alone, std::exp(-1.2), 2e-5) << v.getCoord();
    }
}

TEST_F(SeveralInputs, OtherCoefficientsBecomeCdAndKeepThePicture)
{
    write("a.vdb", body(1), 6, 0.9);
    write("b.vdb", body(2), 2, 0.4);
    const std::string said = done("illuminate", "a.vdb b.vdb --sun 0,1,0 -o both.vdb");
    const GridFile both = read_grid_file(path("both.vdb"));
    const auto density = find_grid(both, "density");
    ASSERT_TRUE(density && vectors(both, schema::colour));
    const Medium m = read_medium(*density);
    EXPECT_EQ(m.sigma_t_per_density, Vec3d(6));
    EXPECT_EQ(m.albedo, Vec3d(0.9));
    EXPECT_EQ(get_text(*density, schema::sigma_t_origin, ""), "given");
    // The product of two interpolants is not the interpolant of the product: albedos differ by a half in clumps.
    EXPECT_NEAR(mean("both.vdb", "") / mean("a.vdb b.vdb", "--sun 0,1,0"), 1, 0.01);
    EXPECT_NEAR(mean("both.vdb", "", "A") / mean("a.vdb b.vdb", "--sun 0,1,0", "A"), 1, 1e-6);
}

TEST_F(SeveralInputs, MetadataAreKeptWhereInputsAgree)
{
    write("a.vdb", body(1), 6, 0.9, 0, {{"history", "one"}, {"up_axis", "Z"}, {"maker", "me"}, {"scene", "first"}});
    write("b.vdb", body(2), 6, 0.9, 0, {{"history", "two"}, {"maker", "me"}, {"scene", "second"}});
    done("illuminate", "-q a.vdb b.vdb -o both.vdb");
    const GridFile both = read_grid_file(path("both.vdb"));
    const std::string history = get_text(*both.metadata, schema::history, "");
    EXPECT_EQ(history.rfind("one\ntwo\nilluminate ", 0), 0u) << history;
    EXPECT_EQ(get_text(*both.metadata, schema::up_axis, ""), "Z");
    EXPECT_EQ(get_text(*both.metadata, "maker", ""), "me");
    EXPECT_FALSE(has_meta(*both.metadata, "scene"));
    const auto sun = lights_of(both);  // automatic, above the horizon of z up
    ASSERT_EQ(sun.size(), 1u);
    EXPECT_GT(sun[0].place()[2], sun[0].place()[1]);

    write("y.vdb", body(2), 6, 0.9, 0, {{"up_axis", "Y"}});
    for (const char* line : {"a.vdb y.vdb -o no.vdb", "y.vdb b.vdb a.vdb -o no.vdb"})
        for (const char* name : {"illuminate", "p1solve"}) {
            const std::string sentence = refused(name, line);
            EXPECT_NE(sentence.find("a.vdb"), std::string::npos) << sentence;
            EXPECT_NE(sentence.find("y.vdb"), std::string::npos) << sentence;
            EXPECT_NE(sentence.find("--up"), std::string::npos) << sentence;
            done(name, "-q --up z " + std::string(line).replace(std::string(line).find("no"), 2, "up"));
            EXPECT_EQ(get_text(*read_grid_file(path("up.vdb")).metadata, schema::up_axis, ""), "Z");
        }
    refused("render", "a.vdb y.vdb -o no.exr");
    done("render", "-q a.vdb y.vdb --up z --resolution 8 -o yes.exr");
    for (const double unit : {1.0, 100.0}) {
        GridFile file = read_grid_file(path("b.vdb"));
        set_number(*file.metadata, schema::meters_per_unit, unit);
        write_grid_file(path("unit" + std::to_string(int(unit)) + ".vdb"), file);
    }
    EXPECT_NE(refused("illuminate", "unit1.vdb unit100.vdb -o no.vdb").find("meters_per_unit"), std::string::npos);
    refused("render", "unit1.vdb unit100.vdb -o no.exr");
    done("illuminate", "-q a.vdb unit100.vdb -o units.vdb");
    EXPECT_EQ(get_number(*read_grid_file(path("units.vdb")).metadata, schema::meters_per_unit, 0), 100);
}

TEST_F(SeveralInputs, AChosenDensityIsTheJoinedOne)
{
    const auto smoke = body(1), veil = body(2);
    smoke->setName("smoke");
    veil->setName("veil");
    for (const char* name : {"a.vdb", "b.vdb"})
        write_grid_file(path(name), file_of({smoke->deepCopy(), veil->deepCopy()}));
    done("illuminate", "-q a.vdb b.vdb --density veil --extinction 3 -o both.vdb");
    const GridFile both = read_grid_file(path("both.vdb"));
    EXPECT_EQ(get_text(*both.metadata, schema::density_choice, ""), "veil");
    const auto density = openvdb::gridPtrCast<FloatGrid>(find_grid(both, "veil"));
    ASSERT_TRUE(density);
    EXPECT_FALSE(find_grid(both, "smoke"));
    for (auto v = density->cbeginValueOn(); v; ++v) EXPECT_EQ(*v, 2 * veil->tree().getValue(v.getCoord()));
    EXPECT_EQ(done("render", "-q both.vdb --resolution 8 -o a.exr"), "");
}

TEST_F(SeveralInputs, ResultsOfOneInputAreDroppedWithALine)
{
    auto heat = body(3);
    heat->setName("temperature");
    set_text(*heat, "vdbcloud:unit", "K");  // as cold as air
    write("a.vdb", body(1), 6, 0.9, 0, {}, {heat});
    write("b.vdb", body(2));
    done("p1solve", "-q a.vdb --sun 0,1,0 -o solved.vdb");
    const std::string said = done("illuminate", "solved.vdb b.vdb -o both.vdb");
    EXPECT_NE(said.find("phi"), std::string::npos) << said;
    EXPECT_NE(said.find("temperature"), std::string::npos) << said;
    const GridFile both = read_grid_file(path("both.vdb"));
    EXPECT_EQ(both.grids.size(), 2u);
    EXPECT_TRUE(find_grid(both, "density") && find_grid(both, "transmittance_sun"));
}

TEST_F(SeveralInputs, ASampledInputIsReported)
{
    write("a.vdb", body(1));
    write("turned.vdb", moved(body(2), Vec3d(0.3, 0.2, 0), 0.5));
    const std::string said = done("illuminate", "a.vdb turned.vdb --sun 0,1,0 -o both.vdb");
    EXPECT_NE(said.find("turned.vdb: density sampled"), std::string::npos) << said;
    // Trilinear twice: clumps of a voxel lose contrast, and light and extinction of the picture change by some percent.
    EXPECT_NEAR(mean("both.vdb", "") / mean("a.vdb turned.vdb", "--sun 0,1,0"), 1, 0.05);
}

TEST_F(SeveralInputs, RenderRefusesMultipleScatteringThatWasComputedApart)
{
    write("a.vdb", body(1));
    write("b.vdb", moved(body(2), Vec3d(0, 3, 0)));
    write("void.vdb", FloatGrid::create(0.0f));
    auto glow = Vec3SGrid::create(Vec3f(0.0f));
    glow->setName("emission");
    glow->tree().setValueOn(Coord(0, 20, 0), Vec3f(1.0f));
    write("fire.vdb", FloatGrid::create(0.0f), 6, 0.9, 0, {}, {glow});
    done("p1solve", "-q a.vdb --sun 0,1,0 -o pa.vdb");
    done("p1solve", "-q b.vdb --sun 0,1,0 -o pb.vdb");
    done("p1solve", "-q a.vdb --sun 0,1,0 --albedo 0.999 --series 2 -o series.vdb");
    for (const char* inputs : {"pa.vdb pb.vdb", "pa.vdb b.vdb", "b.vdb pa.vdb", "pa.vdb fire.vdb", "fire.vdb pa.vdb"}) {
        const std::string sentence = refused("render", std::string(inputs) + " -o no.exr");
        EXPECT_NE(sentence.find(std::string("p1solve ") + inputs + " -o"), std::string::npos) << sentence;
    }
    refused("render", "series.vdb b.vdb --albedo 0.99 -o no.exr");
    done("render", "-q pa.vdb pb.vdb --integrator path --resolution 4 -o path.exr");  // reads no phi
    EXPECT_NEAR(mean("pa.vdb void.vdb", ""), mean("pa.vdb", ""), 1e-6);
    done("p1solve", "-q pa.vdb pb.vdb -o both.vdb");
    EXPECT_GT(mean("both.vdb", "--aov multiscatter", "multiscatter.R"), 1e-3);
}

TEST_F(SeveralInputs, RefusalsNameBothFilesAndTheWayOut)
{
    write("a.vdb", body(1), 6, 0.9, 0);
    write("b.vdb", body(2), 6, 0.9, 0.8);
    const std::string sentence = refused("illuminate", "a.vdb b.vdb --sun 0,1,0 -o no.vdb");
    for (const char* word : {"a.vdb", "b.vdb", "--phase", "p1solve"})
        EXPECT_NE(sentence.find(word), std::string::npos) << sentence;
    for (const char* name : {"illuminate", "p1solve"}) {
        done(name, "-q a.vdb b.vdb --sun 0,1,0 --g 0.5 -o yes.vdb");
        EXPECT_EQ(read_medium(*find_grid(read_grid_file(path("yes.vdb")), "density")).phase,
                  PhaseFunction::henyey_greenstein(0.5));
        refused(name, "- - -o no.vdb < a.vdb");
        done(name, "-q a.vdb - --g 0.5 -o piped.vdb < b.vdb");
        EXPECT_TRUE(find_grid(read_grid_file(path("piped.vdb")), "density"));
    }
    refused("render", "- - -o no.exr < a.vdb");
    done("render", "-q a.vdb b.vdb --sun 0,1,0 --resolution 8 -o yes.exr");
    for (const std::string& file : scratch.list()) EXPECT_EQ(file.rfind("no.", 0), std::string::npos) << file;
}

}  // namespace
}  // namespace vdbcloud::test
