// exrmerge: parts of one picture of render --integrator path, made by different jobs, become the picture of all
// samples.
//
//   exrmerge a.exr b.exr -o both.exr
#include "plan.h"

#include "vdbcloud/render/merge.h"

using namespace vdbcloud;

namespace {

struct Options {
    std::vector<std::string> inputs;
    std::string output;
};

void declare(app::App& app, Options& o)
{
    app.add_option(
           "input", o.inputs,
           ".exr files of render --integrator path: the same scene, view, size, layers and --seed, other samples "
           "(--spp-offset)")
        ->required()
        ->type_name("FILE")
        ->configurable(false)  // sample ranges and history say what the inputs were
        ->allow_extra_args()
        ->expected(-1)
        ->reads_files();
    app.add_option("-o,--output", o.output, "picture of all samples to write: .exr, or - for standard output")
        ->required()
        ->type_name("FILE")
        ->rewrites_file(app::FileKind::Map);
    app.examples(
        {{"two halves of one run",
          "fractalgen --size 32 -o cloud.vdb && render cloud.vdb --integrator path --spp 8 --resolution 64 -o a.exr && "
          "render cloud.vdb --integrator path --spp 8 --spp-offset 8 --resolution 64 -o b.exr && "
          "exrmerge a.exr b.exr -o both.exr"},
         {"how many samples there are, as JSON", "exrmerge a.exr b.exr -o both.exr --json -"},
         {"are the parts of one run? without writing", "exrmerge a.exr b.exr -o both.exr --dry-run"}});
}

/// A value takes 12 bytes while a part is added, and as a rule 2 when the picture is packed.
app::Plan plan_of(const Options& o, const PictureMerge& pictures, app::Plan plan)
{
    plan.bytes = 14.0 * double(pictures.values());
    plan.work.add("merged_value", double(pictures.values()) * double(o.inputs.size() + 1));
    return plan;
}

void merge(app::App& app, const Options& o)
{
    PictureMerge pictures;
    const app::Plan nothing;  // notes what the process holds so far
    {
        const auto reading = app.phase("merge");
        for (const std::string& path : o.inputs) pictures.add(path);
    }
    app.report()["picture"] = {{"samples", pictures.samples()}, {"sample_ranges", pictures.ranges()}};
    app.say(std::to_string(pictures.samples()) + " samples a pixel, of indices " + pictures.ranges());
    const app::Plan plan = plan_of(o, pictures, nothing);
    if (app.dry_run()) return app::tell(app, plan, "merge " + std::to_string(o.inputs.size()) + " pictures");
    app.add_work(plan.work);
    const auto writing = app.phase("write");
    pictures.write(o.output, app.history(pictures.history()), app.no_clobber());
    app.report()["outputs"].push_back({{"path", o.output}});
}

}  // namespace

int main(int argc, char** argv)
{
    app::App app("exrmerge", "Merges pictures of render --integrator path that hold different samples.");
    app.never_clobbers();
    Options o;
    declare(app, o);
    return app.run(argc, argv, [&] { merge(app, o); });
}
