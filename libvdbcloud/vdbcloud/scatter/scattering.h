#pragma once
// Private to scatter/. One run of scatter_p1(): what the steps of a channel share. Sources are in
// scattering_sources.cc, the solve of a channel in scattering_channel.cc and scattering_closed.cc, where its power goes
// in scattering_powers.cc, the rest in multiple_scattering.cc.
#include "vdbcloud/optics/mixture.h"
#include "vdbcloud/scatter/beam_medium.h"
#include "vdbcloud/scatter/channel_groups.h"
#include "vdbcloud/scatter/channel_mixture.h"
#include "vdbcloud/scatter/channel_report.h"
#include "vdbcloud/scatter/collided_grids.h"
#include "vdbcloud/scatter/emission_cost.h"
#include "vdbcloud/scatter/emitted_light.h"
#include "vdbcloud/scatter/endless_ground.h"
#include "vdbcloud/scatter/ground.h"
#include "vdbcloud/scatter/heating.h"
#include "vdbcloud/scatter/multiple_scattering.h"
#include "vdbcloud/scatter/scatter_plan.h"
#include "vdbcloud/scatter/solid_mask.h"
#include "vdbcloud/scatter/solid_walls.h"

#include <functional>
#include <optional>

namespace vdbcloud {

/// What scatter_p1() does, with all that its steps share. Used once.
class Scattering {
public:
    Scattering(const FloatGrid& density, const Vec3SGrid* tint, const Vec3SGrid* emission, const Medium& medium,
               const std::vector<Light>& lights, const ScatterOptions& options, ScatterReport& report);
    CollidedLight run(const Progress& progress);
    const FluenceOf* given = nullptr;  ///< P1's fluence, where it is known without a solve

private:
    /// Null for one medium.
    const ChannelMixture* mixture(int channel) const
    {
        return mixtures_.empty() ? nullptr : &mixtures_[mixture_of_[size_t(channel)]];
    }
    const std::vector<float>& density(int channel) const
    {
        return mixture(channel) ? mixture(channel)->density : density_;
    }
    const std::vector<float>* tint(int channel) const
    {
        if (const ChannelMixture* all = mixture(channel)) return all->tint.empty() ? nullptr : &all->tint;
        if (tint_[0].empty()) return nullptr;
        return tint_[channel].empty() ? &tint_[0] : &tint_[channel];
    }
    const std::vector<float>* emission(int channel) const
    {
        if (emission_[0].empty()) return nullptr;
        return emission_[channel].empty() ? &emission_[0] : &emission_[channel];
    }

    void mix();
    /// Keeps w0 = albedo x tint within [0, 1], as render does.
    void clamp_tint();

    /// Groups of channels that share a matrix or a solution.
    std::vector<ChannelGroup> groups() const;

    BeamMedium beam_medium(const P1Operator& p1) const { return BeamMedium(index_, grid_, p1, solids_.get()); }

    using BeamNote =
        std::function<void(const BeamDepths&, const std::vector<float>&, double, const std::optional<Vec3d>&)>;
    /// Adds the beams of all lights in the medium of a channel. Density depths are found once and kept for all
    /// channels, scalings and sweeps, where these share them: not where the albedo changes from voxel to voxel. `note`,
    /// if given, is called with each light's depths at faces and at centres, the extinction, and the middle of the sun
    /// that the light is a part of.
    void add_beams(const P1Operator& p1, const std::vector<std::pair<P1Source*, int>>& sources,
                   const Progress& progress, const BeamNote& note = {});
    /// Depths of a beam in the density, whatever the extinction.
    struct KeptBeam {
        BeamDepths depths;
        std::vector<float> centres;
        std::optional<LineDepths> lines;
    };
    KeptBeam find_beam(const BeamMedium&, const Light&, bool with_centres, const Progress&);
    /// Finds the depths of a beam that is alone for add_beams(), so that they need no memory beside sources.
    void find_one_beam(const P1Operator& p1, const Progress&);
    bool keeps_beams(const P1Operator& p1) const;
    bool sweeps_take_beams() const { return o_.closure.iterations > 0 || o_.flux_map || endless_; }
    /// How often add_beams() will be called.
    int uses_of_beams(const std::vector<ChannelGroup>& groups) const;
    bool by_rays() const { return allows_rays(o_) && !given; }

    /// Follows the emission of a group's channels by rays.
    void follow_emission(const P1Operator& p1, const ChannelGroup& group);
    const EmittedLight* emitted(int channel) const { return emitted_[channel] ? &*emitted_[channel] : nullptr; }

    /// The part of a channel's emission that is a source of P1 and the sweeps.
    double swept_share(int channel) const
    {
        return !emission(channel) ? 0.0 : emitted_[channel] ? 1 - emitted_share_[size_t(channel)] : 1.0;
    }

    /// Emission as the sweeps take it.
    void add_emission_to(SecondMoment& closure, int c) const;
    void note_bytes(const P1Operator& p1, size_t sources, size_t besides);
    void count_sweeps(const SecondMoment& closure, double sweeps, bool follows = false);
    /// Adds `times` events for each voxel of the blocks.
    void note_work(const char* event, double times)
    {
        report_.work.add(event, times * 512 * double(index_.blocks().count()));
    }
    void solve_group(const ChannelGroup& group, int& done, int count, const Progress& progress);
    /// What all solves of a channel end with.
    void keep(const ChannelGroup::Solve& solve, const std::vector<double>& phi);
    P1Medium medium_of(int channel) const;
    void add_sky_and_glow(const P1Operator& p1, int c, P1Source& source) const;
    void keep_p1(const P1Operator& p1, const P1Source& source, int c, const std::vector<double>& phi,
                 ChannelReport& report);

    /// Adds uncollided light to collided light, components along the index axes.
    void add_light(const EmittedLight& light, std::vector<double>& phi, std::array<std::vector<float>, 3>& flux) const;

    /// Flux-limited diffusion of one channel: solves repeatedly, each time with factors from the last solution.
    void limit(const P1Operator& p1, const P1Source& p1_source, int c, std::vector<double>& phi, ChannelReport& report);

    /// P1's sources of a group's channels.
    std::vector<P1Source> p1_sources(const P1Operator& p1, const ChannelGroup& group, const Progress& progress);
    /// Adds what a ground under a medium that repeats sends up of the lights.
    void add_direct_ground(const P1Operator& p1, int c, P1Source& source);
    /// Notes what the fields and results of the effects hold.
    void note_fields();
    void note_results(const CollidedLight&);
    /// P1's source, with room for what the request needs.
    P1Source source_of(const P1Operator& p1) const;

    /// The sweeps of all channels.
    TransportSweep& transport();
    /// A sweep of degree 1 by uncollided light, without collided light.
    SecondMoment plane_sweep(const P1Operator& p1, int c, ChannelReport& report);

    /// P1's light on the planes, with the angular detail of one sweep.
    void sweep_planes(const P1Operator& p1, int c, const std::vector<double>& phi,
                      std::array<std::vector<float>, 3> flux, PlaneLight& planes, ChannelReport& report);

    /// `flux`: of P1 alone, else null. `swept`: null without a sweep.
    void finish(const P1Operator& p1, const P1Source& source, int c, const std::vector<double>& phi,
                const std::array<std::vector<float>, 3>* flux, const PlaneLight* swept, ChannelReport& report);

    /// The hemisphere of what the report calls reflected.
    Hemisphere hemisphere() const;
    /// A request for the light on the planes, cell by cell only where a map or a ground needs that.
    PlaneLight requested_planes() const
    {
        PlaneLight planes;
        planes.by_cell = o_.flux_map || ground_.has_value();
        return planes;
    }

    /// Radiance that enters along the directions of the sweeps of a channel, from the sky and the endless ground.
    void set_inflow(SecondMoment& closure, int c) const;
    /// The ground as sweeps meet it; none where there is none.
    std::optional<SweepGround> swept_ground(const P1Operator& p1, int c) const;
    /// The solids as the sweeps of a channel meet them, lit by suns and lamps and by the sky without the medium; none
    /// where there are none.
    std::optional<LitWalls> lit_walls(const P1Operator& p1, int c) const;
    /// Keeps what a sweep found on an endless ground.
    void note_patch(const std::optional<SweepGround>& ground);
    /// Solves P1 with the endless ground's light, in a fixed number of rounds, so that lights add up: the patch's light
    /// in a round is that of P1's light in the round before.
    void add_patch(const P1Operator& p1, const P1Source& unlit, int c, const std::function<void(P1Source&)>& solve,
                   std::vector<double>& phi, P1Source& source, ChannelReport& report);

    /// What reaches the ground; the diffuse light of P1 alone, for sweeps bring their own.
    PlaneGround ground_under(const P1Operator& p1, const P1Source& source, int c, const std::vector<double>& phi,
                             bool p1_alone);

    /// `swept`: of sweeps; null for P1 alone.
    void note_ground(const PlaneGround& under, int c, const PlaneLight* swept, ChannelReport& report);
    void note_endless(int c, ChannelReport& report);
    void put_ground();
    /// A field of the solutions, and each channel's scale of it.
    std::pair<std::array<const std::vector<float>*, 3>, Vec3d> by_channel(std::vector<float> Solution::*field) const;
    void fill_map(const P1Operator& p1, int c, const PlaneLight& swept, const PlanePower& planes);
    void put_heating();

    /// What the matrix that sweeps close has of its own. It depends on sigma_tr alone, so channels may share it.
    struct Closing {
        std::array<double, 2> of{};  // extinction, and albedo times mean cosine
        const std::vector<float>* density = nullptr;
        const std::vector<float>* tint = nullptr;
        std::vector<ExposedVoxel> exposed;
        std::vector<float> limiter;
    };
    std::shared_ptr<const Closing> closing(int channel);

    /// The beams of a channel as a source, with the light that has not collided and that which lines lose.
    struct BeamSource {
        ChannelBeams of;
        P1Source source;
        std::vector<std::vector<float>> uncollided;
        double lines;
    };
    /// Adds the beams to what sweeps close. Where a channel's beams are those of another channel times a number, they
    /// are computed once.
    void add_closed_beams(const P1Operator& fine, int c, SecondMoment& closure, P1Source& base, const BeamNote& note);
    /// The matrix of a group of channels that sweeps close, that of closing() in the scaling of P1.
    struct ClosedMatrix {
        std::shared_ptr<const Closing> closing;
        P1Operator p1;
        const ClosedMatrix* like;            // takes its hierarchy; null: none
        std::optional<Multigrid> multigrid;  // from the first solve on
    };
    /// A channel whose light sweeps close.
    struct ClosedChannel {
        ClosedChannel(std::shared_ptr<const Closing> closed_by, const P1Operator& p1, int degree)
            : closing(std::move(closed_by)), fine(p1, degree)
        {
        }
        std::shared_ptr<const Closing> closing;
        P1Operator fine;
        std::optional<SecondMoment> closure;
        std::optional<P1Source> base;
        std::vector<double> phi;
        std::optional<SweepGround> ground;
        std::optional<LitWalls> walls;
        PlaneLight planes;
    };
    /// Solves the transport equation of all channels of some groups.
    void solve_closed(const std::vector<const ChannelGroup*>&, int& done, int count, const Progress& progress);
    /// `others`: those before. A channel that absorbs more than one of them takes the hierarchy of that one.
    ClosedMatrix closed_matrix(const ChannelGroup&, const std::vector<std::unique_ptr<ClosedMatrix>>& others);
    Multigrid& hierarchy(ClosedMatrix&);
    /// P1's solution of a channel, and all that sweeps start from. `others`: channels that may have the same extinction
    /// and light that looks alike.
    std::unique_ptr<ClosedChannel> open(ClosedMatrix&, int c, SolveOptions,
                                        const std::vector<std::unique_ptr<ClosedChannel>>& others);
    /// Puts the light of ScatterOptions::previous in place of P1's, where it is known.
    void start_with_previous(SecondMoment&, int c, std::vector<double>& phi);
    /// `follows`: swept with a channel before.
    void conclude(ClosedChannel&, int c, bool follows, ClosureReport&&);
    SolveResult solve(const P1Operator& p1, Multigrid* multigrid, P1Source& source, std::vector<double>& phi,
                      const SolveOptions& options, const Fields& alike = {});

    int degree() const { return o_.closure.iterations > 0 ? o_.closure.degree : 1; }
    DeltaScaling scaling() const
    {
        if (!mixtures_.empty()) return largest_of(scalings_of(o_.parts, degree(), o_.delta));
        return o_.delta ? delta_scaling(medium_.phase, degree()) : no_scaling(medium_.phase, degree());
    }

    /// The report of a channel whose solution is `scale` times another channel's.
    void share(int from, int to, double scale);
    void stamp(GridBase& grid) const;

    const std::unique_ptr<const SolidRays> solids_;  // null: none
    const FloatGridPtr open_;                        // the density without what lies within solids; null: none does
    const FloatGrid& grid_;
    const Sources sources_;
    const Medium& medium_;
    const std::vector<Light>& lights_;
    const std::vector<Light> beams_;             // without extent, their sum is that of lights_
    std::vector<std::optional<Vec3d>> towards_;  // of each beam: the middle of its sun
    const ScatterOptions o_;
    ScatterReport& report_;
    const SolidSurface surface_;  // as sweeps meet it; empty without sweeps
    VoxelIndex index_;
    std::vector<float> density_;
    std::vector<ChannelMixture> mixtures_;  // of overlapping media: those that differ
    std::array<size_t, 3> mixture_of_{};    // by channel
    std::vector<ExposedVoxel> exposed_;
    std::optional<SweepWalls> walls_;       // the surface on the voxels
    std::optional<GroundPlane> ground_;     // under a medium that repeats
    std::optional<EndlessGround> endless_;  // under a medium that ends on all sides
    // Of the channel that is being finished; on an endless ground their changes by the medium.
    std::vector<float> direct_on_ground_, diffuse_on_ground_;
    std::vector<float> tint_[3], emission_[3];
    std::array<Solution, 3> solution_;
    std::array<Share, 3> share_;
    std::shared_ptr<const Closing> closing_;  // the last
    std::unique_ptr<TransportSweep> transport_;
    std::optional<BeamSource> beam_source_;
    std::vector<std::optional<KeptBeam>> kept_;           // by beam, until the last use
    double beam_bytes_ = 0;                               // most that kept_ holds
    int beam_uses_ = 0;                                   // of add_beams() that are left
    std::array<std::optional<EmittedLight>, 3> emitted_;  // of the solve at work
    std::array<double, 3> emitted_share_{};               // share_by_rays() of it
};

}  // namespace vdbcloud
