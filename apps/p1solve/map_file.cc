#include "map_file.h"

#include "version.h"

#include "vdbcloud/render/image_out.h"

namespace vdbcloud {

void write_flux_map(app::App& app, const P1solveOptions& o, const ScatterReport& report, const std::string& history)
{
    if (!report.flux_map || report.flux_map->width == 0) return;
    const auto phase = app.phase("flux map");
    const FluxMap& map = *report.flux_map;
    Map picture{map.width, map.height, {}};
    for (const FluxMapLayer& layer : flux_map_layers())
        for (size_t c = 0; c < 3; ++c)
            picture.channels.emplace_back(std::string(layer.name) + "." + "RGB"[c], map.channel[c].*layer.values);
    ImageMetadata metadata;
    metadata.creator = app.get_name() + " " + app::project_version();
    metadata.history = app.history(history);
    metadata.texts = {{map_key::unit, "power per area of a column's cross-section, radiance x sr"},
                      {map_key::first_column, app::shortest(map.first)},
                      {map_key::column_step_x, app::shortest(map.step_x)},
                      {map_key::column_step_y, app::shortest(map.step_y)}};
    metadata.numbers = {{map_key::column_area, map.column_area}};
    write_map(o.flux_map, picture, metadata, app.no_clobber());
    app.report()["outputs"].push_back({{"path", o.flux_map}});
    const char* const channels[] = {"r", "g", "b"};
    for (size_t c = 0; c < 3; ++c) {
        auto& budget = app.report()["channels"][channels[c]]["budget"];
        budget["direct_at_top"] = power_of(map, map.channel[c].direct_top);
        budget["direct_at_base"] = power_of(map, map.channel[c].direct_base);
    }
}

}  // namespace vdbcloud
