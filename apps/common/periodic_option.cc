#include "periodic_option.h"

#include "formed.h"
#include "inputs.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/registry.h"
#include "vdbcloud/grid/sources.h"
#include "vdbcloud/optics/collided_light.h"

#include <algorithm>
#include <optional>

namespace vdbcloud::app {

namespace {

/// Nothing if `asked` is of another form.
std::optional<Axes> axes_of(const std::string& asked)
{
    Axes axes{};
    if (asked == "none") return axes;
    if (asked.empty() || asked.size() > 2) return std::nullopt;
    for (const char letter : asked) {
        if (letter < 'x' || letter > 'z' || axes[size_t(letter - 'x')]) return std::nullopt;
        axes[size_t(letter - 'x')] = true;
    }
    return axes;
}

}  // namespace

Option declare_periodic(App& app, std::string& text, const std::string& group)
{
    return app
        .add_option(
            "--periodic", text,
            "axes of the grid along which the medium repeats without end, x, z, xz and so on, or none. The period "
            "is the extent of the density's active voxels. For layers and fields of clouds; without it the "
            "axes of the results in the file, else none")
        .check(formed("none, or one or two of the letters x, y, z; light leaves the medium along the third axis",
                      [](const std::string& axes) { return axes_of(axes).has_value(); }))
        .default_str("")
        .scene("medium")
        .type_name("AXES")
        .group(group);
}

namespace {

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
    if (!asked.empty()) return axes_of(asked).value();
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
