#include "stage_options.h"

namespace vdbcloud::app {

Option declare_density(App& app, std::string& name)
{
    return app.add_option("--density", name,
                          "name of the density grid, or NAME[k]; without it the usual names are tried");
}

void declare_stage(App& app, StageOptions& o, const std::string& input, const std::string& output)
{
    app.add_option("input", o.input, input)->required();
    app.add_option("-o,--output", o.output, output)->required();
    declare_density(app, o.density);
    app.reads_grids();
    app.writes_grids();
}

}  // namespace vdbcloud::app
