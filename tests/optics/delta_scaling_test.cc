// Delta-M scaling of any phase function: conserved quantities, condition for scaling, and metadata.
#include "vdbcloud/optics/delta_scaling.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/scatter_schema.h"
#include "vdbcloud/optics/medium.h"

#include <gtest/gtest.h>

#include <cmath>

namespace vdbcloud {
namespace {

PhaseFunction hg(double g) { return PhaseFunction::henyey_greenstein(g); }

TEST(DeltaScaling, KeepsAbsorptionAndTransportCrossSections)
{
    const PhaseFunction droplets("hg-draine", {15}), lobes("double-henyey-greenstein", {0.9, 0.2, 0.6});
    for (const PhaseFunction& phase : {hg(0.85), hg(-0.9), hg(0), PhaseFunction("rayleigh"), droplets, lobes})
        for (int degree : {1, 2, 3, 7})
            for (double w0 : {1.0, 0.97, 0.5}) {
                const DeltaScaling s = delta_scaling(phase, degree);
                ASSERT_EQ(s.moments.size(), size_t(degree) + 1);
                EXPECT_EQ(s.moments[0], 1);
                EXPECT_NEAR(s.extinction(w0) * (1 - s.albedo(w0)), 1 - w0, 1e-15);
                EXPECT_NEAR(s.extinction(w0) * s.albedo(w0), w0 * s.scattering(), 1e-15);
                for (int l = 1; l <= degree; ++l)
                    EXPECT_NEAR(s.extinction(w0) * (1 - s.albedo(w0) * s.moments[size_t(l)]), 1 - w0 * phase.moment(l),
                                1e-14)
                        << phase.text() << ' ' << degree << ' ' << l;
            }
}

TEST(DeltaScaling, HenyeyGreensteinFractionIsGToTheDegreePlusOne)
{
    for (double g : {0.85, 0.3})
        for (int degree : {1, 3, 7}) EXPECT_EQ(delta_scaling(hg(g), degree).delta_f, std::pow(g, degree + 1));
    EXPECT_NEAR(delta_scaling(hg(0.85), 1).mean_cosine(), 0.85 / 1.85, 1e-15);
}

TEST(DeltaScaling, FractionIsTheMomentAboveTheDegree)
{
    const PhaseFunction droplets("hg-draine", {20});
    for (int degree : {1, 3, 5}) {
        const DeltaScaling s = delta_scaling(droplets, degree);
        EXPECT_EQ(s.delta_f, droplets.moment(degree + 1));
        EXPECT_GT(s.delta_f, 0.5);
        for (double m : s.moments) EXPECT_GE(m, 0);
    }
}

TEST(DeltaScaling, ScalesNothingWhereAScaledMomentWouldBeNegative)
{
    EXPECT_EQ(delta_scaling(hg(-0.9), 1).delta_f, 0);
    EXPECT_EQ(delta_scaling(hg(0), 3).delta_f, 0);
    EXPECT_EQ(delta_scaling(PhaseFunction("rayleigh"), 1).delta_f, 0);  // m_2 = 0.1 above m_1 = 0
    EXPECT_EQ(delta_scaling(PhaseFunction("rayleigh"), 2).delta_f, 0);  // m_3 = 0
    // m_1 = 0, m_2 = 0.64.
    EXPECT_EQ(delta_scaling(PhaseFunction("double-henyey-greenstein", {0.8, -0.8, 0.5}), 1).delta_f, 0);
    EXPECT_EQ(no_scaling(hg(0.85), 3).delta_f, 0);
    EXPECT_EQ(no_scaling(hg(0.85), 3).moments[2], std::pow(0.85, 2));
    EXPECT_THROW(delta_scaling(hg(0.5), 0), InputError);
}

TEST(DeltaScaling, LastDegreeIsTheHighestNonzeroMoment)
{
    EXPECT_EQ(delta_scaling(PhaseFunction("isotropic"), 5).last_degree(), 0);
    EXPECT_EQ(delta_scaling(PhaseFunction("rayleigh"), 1).last_degree(), 0);
    EXPECT_EQ(delta_scaling(PhaseFunction("rayleigh"), 5).last_degree(), 2);
    EXPECT_EQ(delta_scaling(hg(0.85), 5).last_degree(), 5);
}

TEST(DeltaScaling, MetadataRoundTripIsExact)
{
    for (const PhaseFunction& phase : {hg(0.85), PhaseFunction("rayleigh"), PhaseFunction("hg-draine", {7})})
        for (int degree : {1, 4}) {
            MetaMap metadata;
            const DeltaScaling written = delta_scaling(phase, degree);
            write_delta_scaling(metadata, written);
            const DeltaScaling read =
                read_delta_scaling(metadata, PhaseFunction());  // the file's moments take precedence
            EXPECT_EQ(read.degree, written.degree);
            EXPECT_EQ(read.delta_f, written.delta_f);
            EXPECT_EQ(read.moments, written.moments);
        }
}

TEST(DeltaScaling, ReadsMissingMomentsFromThePhaseFunction)
{
    MetaMap metadata;
    set_number(metadata, schema::degree, 3);
    set_number(metadata, schema::delta_f, std::pow(0.85, 4));
    const DeltaScaling read = read_delta_scaling(metadata, hg(0.85)), made = delta_scaling(hg(0.85), 3);
    EXPECT_EQ(read.degree, 3);
    EXPECT_EQ(read.moments, made.moments);
    const DeltaScaling nothing = read_delta_scaling(MetaMap(), hg(0.85));
    EXPECT_EQ(nothing.degree, 1);
    EXPECT_EQ(nothing.delta_f, 0);
}

TEST(DeltaScaling, RefusesInvalidMetadata)
{
    const auto refused = [](const char* key, auto change) {
        MetaMap metadata;
        write_delta_scaling(metadata, delta_scaling(hg(0.85), 2));
        change(metadata);
        try {
            read_delta_scaling(metadata, hg(0.85));
            ADD_FAILURE() << "accepted a wrong " << key;
        } catch (const InputError& error) {
            EXPECT_NE(std::string(error.what()).find(key), std::string::npos) << error.what();
        }
    };
    for (double degree : {0.0, 1.5, 1e9})
        refused(schema::degree, [&](MetaMap& m) { set_number(m, schema::degree, degree); });
    for (const char* key : {schema::degree, schema::delta_f}) refused(key, [&](MetaMap& m) { m.removeMeta(key); });
    for (double f : {-0.1, 1.0}) refused(schema::delta_f, [&](MetaMap& m) { set_number(m, schema::delta_f, f); });
    for (const char* text : {"1 0.5", "1 0.5 0.2 0.1", "0.9 0.5 0.2", "1 0.5 2", "1 0.5 x"})
        refused(schema::scaled_moments, [&](MetaMap& m) { set_text(m, schema::scaled_moments, text); });
}

TEST(DeltaScaling, RefusesTheScalingOfAnotherPhaseFunction)
{
    Medium medium;
    medium.phase = hg(0.85);
    const auto said = [&](const DeltaScaling& scaling) -> std::string {
        MetaMap metadata;
        write_medium(metadata, medium);
        write_delta_scaling(metadata, scaling);
        try {
            read_delta_scaling(metadata, medium.phase);
        } catch (const InputError& error) {
            return error.what();
        }
        return "";
    };
    for (const int degree : {1, 3, 7}) {
        EXPECT_EQ(said(delta_scaling(hg(0.85), degree)), "");
        EXPECT_EQ(said(no_scaling(hg(0.85), degree)), "");
        EXPECT_NE(said(delta_scaling(hg(0.8), degree)).find("delta_f' = "), std::string::npos);
        DeltaScaling changed = delta_scaling(hg(0.85), degree);
        changed.delta_f *= 0.99;
        EXPECT_NE(said(changed).find("expected 0 or "), std::string::npos);
        changed = delta_scaling(hg(0.85), degree);
        changed.moments[1] += 1e-6;
        EXPECT_NE(said(changed).find("moment 1 is "), std::string::npos);
    }
}

}  // namespace
}  // namespace vdbcloud
