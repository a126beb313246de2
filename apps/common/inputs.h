#pragma once
// Several .vdb files as the input of one program.
#include "app.h"
#include "medium_options.h"
#include "periodic_option.h"
#include "stage_options.h"

#include "vdbcloud/core/of_file.h"
#include "vdbcloud/optics/joined_medium.h"
#include "vdbcloud/scene/light.h"

#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace vdbcloud::app {

using vdbcloud::of_file;

/// What the inputs of one run say of the world that they share, and what later stages rely on: the axis that points up
/// and the unit of length.
class World {
public:
    /// `compare_up`: false where the user chooses the axis.
    explicit World(bool compare_up);

    /// Takes note of a file. Throws UsageError, which names both files, if an earlier one says something else.
    void add(const std::string& file, const MetaMap&);
    /// Adds to the metadata of an output what the inputs say and the metadata do not.
    void complete(MetaMap&) const;

private:
    /// One property that all files have to state alike, if they state it.
    class Fact {
    public:
        Fact(std::string what, std::string way_out) : what_(std::move(what)), way_out_(std::move(way_out)) {}
        /// An empty value agrees with all.
        void require(const std::string& file, const std::string& value);

    private:
        std::string what_, way_out_, file_, value_;
    };

    bool compare_up_;
    Fact up_{"the up axis", "choose with --up"}, unit_{"meters_per_unit", "expected inputs in one unit of length"};
    std::shared_ptr<MetaMap> said_;
};

/// Reads all inputs, in order. A file of media that overlap (schema::media) becomes a GridFile for each, with its
/// density and its Cd, of which the first keeps all other grids; not where the user chose a `density`.
/// Throws UsageError where two files state different units of length, and, with `compare_up`, where two files state
/// different axes that point up.
std::vector<GridFile> read_inputs(App&, const std::vector<std::string>& paths, const std::string& density,
                                  bool compare_up = true);

/// True for a medium after the first of a file.
bool is_further_medium(const GridFile&);

/// The lights that one input describes.
struct LightsOfInput {
    std::string file;
    std::vector<Light> lights;
};
std::vector<LightsOfInput> lights_found(const std::vector<GridFile>&);

/// Each light once, without those whose place a light of `asked` takes, of the same name or the same light. Lights of
/// two inputs are one where they are the same, by whatever names; of two that differ and have one name the second gets
/// another. Throws UsageError where two inputs contradict each other: each has a light of one name that the other has
/// not. The order of inputs decides on names alone.
std::vector<Light> inherited_lights(const std::vector<LightsOfInput>&, const std::vector<Light>& asked = {});

/// One medium, and the file that a stage completes and writes.
struct MediumInput {
    GridFile file;
    FloatGridPtr density;  ///< a grid of `file`, which bears the medium
    Medium medium;
    Fire fire;        ///< of one input; that of several is in the emission of `file`
    Axes periodic{};  ///< index axes along which the medium repeats
    /// Media that overlap (JoinedMedium::parts), of which `density` is a description that `file` does not hold; empty:
    /// one medium.
    std::vector<MediumPart> parts;
    std::vector<LightsOfInput> lights;  ///< of all inputs
};

/// Reads the inputs and finds density and medium of each (density_of, chosen_medium).
///
/// One input: the file as it is. Several: joined_medium() of all. The file then holds the joined density, Cd and
/// emission, which holds the light of their fires, and says so in one line if it drops other grids: results that were
/// computed for an input alone are not those of the joined medium. Metadata of files and densities are kept where all
/// inputs that have a key agree on its value; the history is that of all inputs. Axes that point up, and those along
/// which media repeat, are compared unless the user gives them.
///
/// `may_overlap`: media of different phase functions or colours are not refused but kept apart (MediumInput::parts):
/// the file then holds a density and a Cd for each.
MediumInput read_one_medium(App&, const StageOptions&, const MediumOptions&, bool may_overlap = false);

}  // namespace vdbcloud::app
