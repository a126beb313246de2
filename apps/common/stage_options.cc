#include "stage_options.h"

#include "periodic_option.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/grid_file.h"

namespace vdbcloud::app {

Option declare_density(App& app, std::string& name)
{
    return app.add_option("--density", name,
                          "name of the density grid, or NAME[k]; without it the usual names are tried");
}

Option declare_up(App& app, std::optional<UpAxis>& up, const std::string& group)
{
    return app
        .add_choice<std::optional<UpAxis>>("--up", up, up_axis_choices<std::optional<UpAxis>>(),
                                           "axis that points up; without it the file's, else y")
        .default_str("")
        .scene("medium")
        .group(group);
}

UpAxis settled_up(App& app, const std::optional<UpAxis>& asked, GridFile& file, bool matters)
{
    const std::optional<UpAxis> said = read_up_axis(*file.metadata);
    const UpAxis up = asked.value_or(said.value_or(UpAxis::Y));
    if (!asked && !said && matters)
        app.say(printable(file.path, 4096) + " does not say which axis is up, taken as y; with --up z it is z");
    if (asked || matters) write_up_axis(*file.metadata, up);
    return up;
}

void declare_inputs(App& app, std::vector<std::string>& paths, const std::string& help)
{
    app.add_option("input", paths, help)
        ->required()
        ->type_name("FILE")
        ->allow_extra_args()
        ->expected(-1)
        ->reads_files();
}

void declare_stage(App& app, StageOptions& o, const std::string& input, const std::string& output)
{
    declare_inputs(app, o.inputs, input);
    app.add_option("-o,--output", o.output, output)->required()->rewrites_file(FileKind::Grids);
    declare_density(app, o.density);
    declare_up(app, o.up, "Lights");
    declare_periodic(app, o.periodic, "Medium");
    app.reads_grids();
    app.writes_grids();
    app.takes_frames(/*several_inputs=*/true);
}

void place_stage(StageOptions& o, const App::PlaceFrame& place)
{
    for (std::string& input : o.inputs) place(input);
    place(o.output);
}

}  // namespace vdbcloud::app
