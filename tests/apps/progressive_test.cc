// render --progressive and --time-limit as a user runs them.
#include "in_folder.h"
#include "support/picture_file.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace vdbcloud::test {
namespace {

class Progressive : public InFolder<Progressive> {
public:
    static constexpr const char* made =
        "fractalgen -q --size 24 -o cloud.vdb && illuminate -q cloud.vdb --extinction 20 --albedo 0.9 --g 0.5 "
        "--sun 0.3,1,0.2 -o lit.vdb && p1solve -q lit.vdb -o solved.vdb";
};

TEST_F(Progressive, EndsWithTheBytesOfAPlainRun)
{
    for (const std::string options :
         {"--resolution 50x41 --samples 2 --aov all", "--resolution 30 --crop 3,4,27,29 --integrator steps",
          "--resolution 24 --integrator path --spp 20 --aov standard_error",
          "--resolution 20 --gather 2 --spp 6 --exposure 1"}) {
        expect_done("render -q solved.vdb " + options + " -o plain.exr --png plain.png");
        expect_done("render -q solved.vdb " + options + " --progressive -o shown.exr --png shown.png");
        EXPECT_EQ(in_folder("cmp plain.exr shown.exr && cmp plain.png shown.png").status, 0) << options;
    }
    // A .png as --output is shown, too.
    expect_done(
        "render -q solved.vdb --resolution 24 -o plain.png && render -q solved.vdb --resolution 24 --progressive -o "
        "shown.png && cmp plain.png shown.png");
}

TEST_F(Progressive, APictureIsThereBeforeTheEndAndWholeAtAnyTime)
{
    // Whoever reads the .png while it is written finds a whole picture; the first says that it is not finished.
    const RunResult r =
        in_folder("rm -f p.png p.exr; render -q solved.vdb --integrator path --spp 4000 --resolution "
                  "96 --progressive --threads 1 "
                  "-o p.exr --png p.png & "
                  "n=0; while kill -0 $! 2> /dev/null; do if [ -e p.png ]; then cp p.png copy.png; "
                  "oiiotool --info -v copy.png > info.txt 2>&1 || echo broken; oiiotool copy.png "
                  "--printstats > stats.txt 2>&1 || echo broken; "
                  "grep -q unfinished info.txt && n=$((n + 1)); [ $n -lt 4 ] || { kill $!; break; }; fi; sleep "
                  "0.05; done; wait $!; echo status $? seen $n; "
                  "ls -a | grep -c '^\\.p\\.'; [ -e p.exr ] && echo exr; true");
    EXPECT_EQ(r.out, "status 143 seen 4\n0\n") << r.err;
    const PictureFile left = picture(*folder_ / "p.png");
    EXPECT_EQ(left.width, 96);
}

TEST_F(Progressive, ASignalAtAnyMomentLeavesAWholePictureOrNone)
{
    for (const char* delay : {"0.02", "0.1", "0.3", "0.45", "0.7", "0.9"}) {
        const RunResult r = in_folder(
            std::string("rm -f p.png; render -q solved.vdb --integrator romberg --samples 64 --resolution 256 "
                        "--progressive -o p.exr --png p.png & sleep ") +
            delay +
            "; kill $!; wait $!; [ ! -e p.png ] || oiiotool p.png --printstats > /dev/null || echo broken; "
            "ls -a | grep '^\\.p\\.'; true");
        EXPECT_EQ(r.out, "") << delay;
    }
}

TEST_F(Progressive, TheTimeLimitOfAPictureWithoutNoiseLeavesCoarsePixels)
{
    expect_done("render -q solved.vdb --resolution 40 -o whole.exr");
    const RunResult r = expect_done("render solved.vdb --resolution 40 --time-limit 1e-9 --json r.json -o coarse.exr");
    EXPECT_NE(
        r.err.find(
            "render: the time limit ended the picture at blocks of 8x8 pixels: 25 of 1600 pixels are computed, the "
            "others repeat their neighbours\n"),
        std::string::npos)
        << r.err;
    const auto report = nlohmann::json::parse(read_text(*folder_ / "r.json"));
    EXPECT_EQ(report["picture"]["coarseness"], 8);
    EXPECT_EQ(report["picture"]["computed_pixels"], 25);
    const PictureFile coarse = picture(*folder_ / "coarse.exr"), whole = picture(*folder_ / "whole.exr");
    EXPECT_EQ(coarse.number("vdbcloud:coarseness"), 8);
    const auto at = [&](const PictureFile& p, size_t i, size_t j) {
        return p.pixels[(j * 40 + i) * p.channels.size()];
    };
    for (size_t j = 0; j < 40; ++j)
        for (size_t i = 0; i < 40; ++i) EXPECT_EQ(at(coarse, i, j), at(whole, i / 8 * 8, j / 8 * 8));
    // With time enough, the picture is the plain one.
    const RunResult enough =
        expect_done("render solved.vdb --resolution 40 --time-limit 1000 --json r.json -o enough.exr && "
                    "idiff -q -fail 0 -warn 0 enough.exr whole.exr");
    EXPECT_EQ(enough.err.find("time limit"), std::string::npos) << enough.err;
    EXPECT_EQ(nlohmann::json::parse(read_text(*folder_ / "r.json"))["picture"]["coarseness"], 1);
}

TEST_F(Progressive, AFileThatIsThereStaysWithNoClobber)
{
    expect_done("rm -f p.png p.exr; render -q lit.vdb --resolution 24 --no-clobber --progressive -o p.exr --png p.png");
    EXPECT_EQ(
        in_folder(
            "rm -f p.exr; cp p.png before.png; render -q lit.vdb --resolution 20 --no-clobber --progressive -o p.exr "
            "--png p.png")
            .status,
        1);
    EXPECT_EQ(in_folder("cmp p.png before.png").status, 0);
}

}  // namespace
}  // namespace vdbcloud::test
