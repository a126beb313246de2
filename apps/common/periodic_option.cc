#include "periodic_option.h"

#include "inputs.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/registry.h"
#include "vdbcloud/grid/sources.h"
#include "vdbcloud/optics/collided_light.h"

#include <algorithm>
#include <optional>

namespace vdbcloud::app {

Option declare_periodic(App& app, std::string& text, const std::string& group)
{
    return app
        .add_option(
            "--periodic", text,
            "axes of the grid along which the medium repeats without end, x, z, xz and so on, or none. The period "
            "is the extent of the density's active voxels. For layers and fields of clouds; without it the "
            "axes of the results in the file, else none")
        .default_str("")
        .type_name("AXES")
        .group(group);
}

namespace {

Axes axes_asked(const std::string& asked)
{
    Axes axes{};
    if (asked == "none") return axes;
    bool right = asked.size() <= 2;
    for (const char letter : asked) {
        right = right && letter >= 'x' && letter <= 'z' && !axes[size_t(letter - 'x')];
        if (right) axes[size_t(letter - 'x')] = true;
    }
    if (!right)
        throw UsageError("--periodic " + printable(asked) +
                         ": expected none, or one or two of the letters x, y, z; light leaves the medium along the "
                         "third axis");
    return axes;
}

/// The results that depend on how the medium repeats.
std::vector<GridBasePtr> results(const GridFile& file)
{
    std::vector<GridBasePtr> found{fluence_grid(file), find_grid(file, schema::series_phi_name(0))};
    found.erase(std::remove(found.begin(), found.end(), nullptr), found.end());
    for (const GridBasePtr& grid : file.grids)
        if (schema::has_role(grid->getName(), schema::Role::Transmittance)) found.push_back(grid);
    return found;
}

std::string described(const GridFile& file, const GridBase& grid)
{
    return printable(grid.getName()) + " of " + file.path + " belongs to a medium periodic along " +
           periodic_text(read_periodic(grid));
}

}  // namespace

Axes periodic_axes(const std::string& asked, const std::vector<GridFile>& files)
{
    if (!asked.empty()) return axes_asked(asked);
    std::optional<Axes> axes;
    std::string first;
    for (const GridFile& file : files)
        for (const GridBasePtr& grid : results(file)) {
            const Axes theirs = of_file(file.path, [&] { return read_periodic(*grid); });
            if (axes && theirs != *axes)
                throw UsageError(first + ", and " + described(file, *grid) + ": choose with --periodic");
            if (!axes) first = described(file, *grid);
            axes = theirs;
        }
    return axes.value_or(Axes{});
}

}  // namespace vdbcloud::app
