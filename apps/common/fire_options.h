#pragma once
// Options for fire: the temperature of a medium, and what it emits.
#include "app.h"

#include "vdbcloud/optics/thermal_emission.h"

#include <memory>
#include <optional>
#include <vector>

namespace vdbcloud::app {

struct FireOptions {
    double scale = 1, offset = 0, intensity = 1, flame = 0;
    struct {
        Option scale, offset, intensity, flame;
    } option;
    /// The scale that was guessed for the first frame of a run, which all frames share.
    std::shared_ptr<std::optional<double>> guess = std::make_shared<std::optional<double>>();
};

/// The albedo of a medium that burns, where nothing gives one: soot of a flame (Modest, Radiative Heat Transfer, 3rd
/// ed. 2013, section 12.9: agglomerates of some hundred primary particles scatter a fifth to a third of the light).
constexpr double soot_albedo = 0.25;

/// --temperature-scale --temperature-offset --fire-intensity --flame-absorption. Keeps references to `o`.
void declare_fire(App&, FireOptions&, const std::string& group);

/// Throws UsageError for an option that has an effect on none of the files.
void check_fire(const FireOptions&, const std::vector<GridFile>&);

/// The grids of a file that say where it is hot, and what their values mean: as the options say, else the metadata of
/// the grids, else kelvin. A greatest value below 100 without a unit is taken as normalised, and 2000 K as its
/// temperature; a line says so. What was chosen is written into the metadata of the grids, so that later stages take
/// the same. No fire (Fire::heat() is null) where no temperature reaches coldest_light, as in the air of a cloud.
/// Throws InputError for values that are not finite.
Fire fire_of(App&, const GridFile&, const FireOptions&);

/// What a medium emits: the file's grid `emission`, and the emission of its fire. Null: nothing.
Vec3SGridPtr emission_of(App&, const GridFile&, const Fire&, const FloatGrid& density, const Medium&,
                         const Vec3SGrid* tint);

}  // namespace vdbcloud::app
