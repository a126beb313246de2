#pragma once
// Several .vdb files as the input of one program.
#include "app.h"
#include "medium_options.h"
#include "periodic_option.h"
#include "stage_options.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/scene/light.h"

#include <string>
#include <vector>

namespace vdbcloud::app {

/// work(), whose InputError says which file it is about: "PATH: MESSAGE".
template<typename Work>
auto of_file(const std::string& path, const Work& work)
{
    try {
        return work();
    } catch (const InputError& e) {
        const std::string file = printable(path, 4096) + ": ", message = e.what();
        throw InputError(message.rfind(file, 0) == 0 ? message : file + message);
    }
}

/// Reads all inputs, in order. Throws UsageError if standard input is named twice, where two files state different
/// units of length, and, with `compare_up`, where two files state different axes that point up.
std::vector<GridFile> read_inputs(App&, const std::vector<std::string>& paths, bool compare_up = true);

/// A light that a file describes.
struct FoundLight {
    std::string file;
    Light light;
};
std::vector<FoundLight> lights_found(const std::vector<GridFile>&);

/// Each light once, without those whose name is in `asked`. Throws UsageError where two lights of one name differ.
std::vector<Light> inherited_lights(const std::vector<FoundLight>&, const std::vector<Light>& asked = {});

/// One medium, and the file that a stage completes and writes.
struct MediumInput {
    GridFile file;
    FloatGridPtr density;  ///< a grid of `file`, which bears the medium
    Medium medium;
    Axes periodic{};                 ///< index axes along which the medium repeats
    std::vector<FoundLight> lights;  ///< of all inputs
};

/// Reads the inputs and finds density and medium of each (density_of, chosen_medium).
///
/// One input: the file as it is. Several: joined_medium() of all. The file then holds the joined density, Cd and
/// emission, and says so in one line if it drops other grids: results that were computed for an input alone are not
/// those of the joined medium. Metadata of files and densities are kept where all inputs that have a key agree on its
/// value; the history is that of all inputs.
/// Axes that point up, and those along which media repeat, are compared unless the user gives them.
MediumInput read_one_medium(App&, const StageOptions&, const MediumOptions&);

}  // namespace vdbcloud::app
