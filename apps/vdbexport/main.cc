// vdbexport: grids for other programs: netCDF by the CF conventions, for xarray and its like, or a USD description of
// the .vdb, for Solaris and its like.
//
//   vdbexport lit.vdb -o lit.nc
//   vdbexport cloud.vdb -o cloud.usda
#include "app.h"
#include "frames.h"

#include "vdbcloud/core/atomic_file.h"
#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/exchange/export_netcdf.h"
#include "vdbcloud/exchange/usd.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/schema.h"
#include "vdbcloud/grid/select.h"

#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <optional>

using namespace vdbcloud;

namespace {

struct Options {
    std::string input, output;
    std::vector<std::string> grids;
};

void declare(app::App& app, Options& o)
{
    app.reads_grids();
    app.never_clobbers();
    app.takes_frames(false);
    app.add_option("input", o.input, "the .vdb to pass on, or - for standard input")
        ->required()
        ->type_name("FILE")
        ->reads_files();
    app.add_option("-o,--output", o.output,
                   "the file to write: .nc holds the grids' values on the box of their active voxels, z up, with "
                   "coordinates and units by the CF conventions; .usda names the .vdb and its grids, as a Volume of "
                   "UsdVol, and with --frames "
                   "all files of a sequence")
        ->required()
        ->type_name("FILE")
        ->writes_frames(app::FileKind::Any);
    app.add_option("--grid", o.grids, "grid to pass on, NAME or NAME[k]; again for a further one; without it all");
    app.examples(
        {{"a lit cloud for xarray: density, extinction, fluence and heating",
          "fractalgen --size 24 -o cloud.vdb && p1solve cloud.vdb --sun 0,1,0 --albedo 0.99 --heating -o lit.vdb && "
          "vdbexport lit.vdb -o lit.nc"},
         {"the fluence alone", "vdbexport lit.vdb --grid phi -o phi.nc"},
         {"the same cloud for Solaris and other programs of USD", "vdbexport lit.vdb -o lit.usda"}});
}

enum class Form { NetCdf, Usda };

/// Throws UsageError for another extension.
Form form_of(const std::string& output)
{
    const std::string extension = std::filesystem::path(output).extension().string();
    if (extension == ".nc") return Form::NetCdf;
    if (extension == ".usda") return Form::Usda;
    throw UsageError("--output " + printable(output) + ": expected a name that ends in .nc or .usda");
}

void write_text_file(const app::App& app, const std::string& path, const std::string& text)
{
    AtomicFile file(path, app.no_clobber());
    for (size_t at = 0; at < text.size();) {
        const ssize_t done = ::write(file.descriptor(), text.data() + at, text.size() - at);
        if (done < 0 && errno != EINTR) throw IoError(system_message(path, "cannot write", errno));
        if (done > 0) at += size_t(done);
    }
    file.commit();
}

/// The input with the grids that are asked for.
GridFile read(app::App& app, const Options& o)
{
    GridFile file = app.read(o.input);
    if (o.grids.empty()) return file;
    std::vector<GridBasePtr> chosen;
    for (const std::string& name : o.grids) chosen.push_back(chosen_grid(file, name));
    file.grids = chosen;
    return file;
}

void write_usda(app::App& app, const std::string& output, const UsdVolume& volume)
{
    if (app.dry_run()) return;
    app.check_output(output);
    write_text_file(app, output, volume.text());
    app.report()["outputs"].push_back({{"path", output}});
}

/// A description of a file, or of one frame of a sequence.
void describe(app::App& app, const Options& o, std::optional<int> frame, UsdVolume& volume)
{
    if (o.input == "-") throw UsageError("input -: a .usda names the .vdb, so the input has to be a file");
    const GridFile file = read(app, o);
    volume.add(file, relative_asset(o.input, o.output), frame);
    if (!has_meta(*file.metadata, schema::meters_per_unit))
        app.say("metersPerUnit 1, assumed: the file has no meters_per_unit");
}

void write_values(app::App& app, const Options& o)
{
    const GridFile file = read(app, o);
    if (app.dry_run()) return;
    const auto writing = app.phase("write");
    app.check_output(o.output);
    const std::string history = app.history(get_text(*file.metadata, schema::history, ""));
    for (const std::string& line : write_netcdf(o.output, file, history, app.no_clobber())) app.say(line);
    app.report()["outputs"].push_back({{"path", o.output}});
}

void pass_on(app::App& app, const Options& o)
{
    const Form form = form_of(o.output);
    const auto asked = app.get_option("--frames")->results();
    const std::vector<int> frames = asked.empty() ? std::vector<int>() : app::frame_numbers(asked.front());
    const bool sequence = form == Form::Usda && !frames.empty() && !app::FramePattern::in("--output", o.output);
    UsdVolume all;
    std::string written;
    size_t k = 0;
    app.each_frame([&](const app::App::PlaceFrame& place) {
        Options frame = o;
        place(frame.input);
        place(frame.output);
        app::require_placed(frame.output);
        if (sequence) return describe(app, frame, frames[k++], all);
        app::require_numbered(frame.output, written);
        if (form == Form::NetCdf) return write_values(app, frame);
        UsdVolume one;
        describe(app, frame, std::nullopt, one);
        write_usda(app, frame.output, one);
    });
    if (sequence) write_usda(app, o.output, all);
}

}  // namespace

// NOLINTNEXTLINE(bugprone-exception-escape): only a wrong declaration throws outside run()
int main(int argc, char** argv)
{
    app::App app("vdbexport", "Grids for other programs: netCDF by the CF conventions, or a description in USD.");
    Options o;
    declare(app, o);
    return app.run(argc, argv, [&] { pass_on(app, o); });
}
