// Coefficients of a medium as metadata: round trip, defaults for missing keys, errors for invalid values.
#include "vdbcloud/optics/medium.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/schema.h"

#include <gtest/gtest.h>

#include <cmath>

namespace vdbcloud {
namespace {

Medium cloud()
{
    Medium medium;
    medium.sigma_t_per_density = Vec3d(3, 4, 5.5);
    medium.albedo = Vec3d(0.9, 0.99, 1);
    medium.phase = PhaseFunction::henyey_greenstein(-0.25);
    return medium;
}

void expect_equal(const Medium& a, const Medium& b)
{
    EXPECT_EQ(a.sigma_t_per_density, b.sigma_t_per_density);
    EXPECT_EQ(a.albedo, b.albedo);
    EXPECT_STREQ(a.phase.name(), b.phase.name());
    EXPECT_EQ(a.phase.parameters(), b.phase.parameters());
}

TEST(Medium, MetadataRoundTripIsExact)
{
    for (const PhaseFunction& phase :
         {PhaseFunction("isotropic"), PhaseFunction("rayleigh"), PhaseFunction::henyey_greenstein(-0.25),
          PhaseFunction("double-henyey-greenstein", {0.8, -0.3, 0.7}), PhaseFunction("hg-draine", {12})}) {
        Medium medium = cloud();
        medium.phase = phase;
        MetaMap metadata;
        write_medium(metadata, medium);
        expect_equal(read_medium(metadata), medium);
    }
}

TEST(Medium, WritingRemovesTheParametersOfAnotherPhaseFunction)
{
    MetaMap metadata;
    write_medium(metadata, cloud());
    Medium droplets = cloud();
    droplets.phase = PhaseFunction("hg-draine", {12});
    write_medium(metadata, droplets);
    EXPECT_FALSE(has_meta(metadata, schema::g));
    EXPECT_EQ(get_number(metadata, "vdbcloud:droplet_diameter", 0), 12);
}

TEST(Medium, MissingMetadataKeepsTheGivenCoefficients)
{
    MetaMap metadata;
    expect_equal(read_medium(metadata, cloud()), cloud());
    set_number(metadata, schema::g, 0.5);
    Medium expected = cloud();
    expected.phase = PhaseFunction::henyey_greenstein(0.5);
    expect_equal(read_medium(metadata, cloud()), expected);
}

TEST(Medium, IsGreyWhereChannelsShareOneExtinction)
{
    EXPECT_FALSE(cloud().grey());
    EXPECT_TRUE(Medium{}.grey());
}

TEST(Medium, RefusesInvalidCoefficientsByName)
{
    const auto refused = [](const char* key, auto change) {
        Medium medium = cloud();
        change(medium);
        MetaMap metadata;
        try {
            write_medium(metadata, medium);
            ADD_FAILURE() << "took a wrong " << key;
        } catch (const InputError& error) {
            EXPECT_NE(std::string(error.what()).find(key), std::string::npos) << error.what();
        }
        EXPECT_EQ(metadata.metaCount(), 0u) << "wrote before it checked";
    };
    refused(schema::sigma_t_per_density, [](Medium& m) { m.sigma_t_per_density[1] = -1; });
    refused(schema::sigma_t_per_density, [](Medium& m) { m.sigma_t_per_density[2] = INFINITY; });
    refused(schema::albedo, [](Medium& m) { m.albedo[0] = 1.01; });
    refused(schema::albedo, [](Medium& m) { m.albedo[0] = std::nan(""); });
}

TEST(Medium, RefusesInvalidFileMetadata)
{
    MetaMap metadata;
    set_text(metadata, schema::phase, "mie\n\x1b[31m");
    try {
        read_medium(metadata);
        FAIL() << "took an unknown phase function";
    } catch (const InputError& error) {
        EXPECT_NE(std::string(error.what()).find("henyey-greenstein"), std::string::npos);
        EXPECT_EQ(std::string(error.what()).find('\x1b'), std::string::npos) << "printed what a file said, uncleaned";
    }
    MetaMap number;
    set_number(number, schema::albedo, 0.5);  // a scalar, but a vector is expected
    EXPECT_THROW(read_medium(number), InputError);
    MetaMap g;
    set_number(g, schema::g, 2);
    try {
        read_medium(g);
        FAIL() << "took g = 2";
    } catch (const InputError& error) {
        EXPECT_STREQ(error.what(), "metadata 'vdbcloud:g' = 2: expected a number in (-1, 1)");
    }
    MetaMap droplets;
    set_text(droplets, schema::phase, "hg-draine");
    EXPECT_THROW(read_medium(droplets), InputError) << "no diameter";
}

}  // namespace
}  // namespace vdbcloud
